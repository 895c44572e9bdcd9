"""What a console may take: a small model written from the documentation, not from the parser that it judges."""

import re
import unicodedata
from typing import Literal

Verdict = Literal["silent", "rejected", "taken", "moves", "estop", "disable", "shutdown", "upset"]
"""`upset` and `shutdown` are taken too, and leave a robot that must be set right before one can go on."""

LONGEST = 4096
_NUMBER = re.compile(rb"[+-]?([0-9]+[.]?[0-9]*|[.][0-9]+)".decode(), re.ASCII)
_BIDI = "\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
_SENSORS = ("forward", "back", "left", "right", "bottom")
_REPORTS = ("telemetry", "settings", "statistics", "health", "events")
_UNITS = ("motors", "ranges", "drive", "world")
_DEVICES = ("motor_controller", "range_board")
_BARE: dict[str, Verdict] = {
    **dict.fromkeys(("s", "S", "stop", "status", "enable", "map", "picture", "reset", "help"), "taken"),
    "f": "moves",
    "b": "moves",
    "disable": "disable",
    "estop": "estop",
    "Shutdown": "shutdown",
}


def judge(raw: bytes, programs: tuple[str, ...], *, piped: bool) -> Verdict:
    """Return what becomes of a line; only a piped console leaves out comments."""
    line = raw.decode(errors="surrogateescape")
    if not line.strip() or (piped and line.lstrip().startswith("#")):
        return "silent"
    if len(line) > LONGEST:
        return "rejected"
    line = line.strip(" \t\r\n")
    if any(_foreign(char) for char in line):
        return "rejected"
    line = line.strip()
    if line.startswith("!"):
        return "rejected"
    return _path(line, programs) if line.startswith("/") else _words(line, programs)


def _foreign(char: str) -> bool:
    return char in _BIDI or unicodedata.category(char) in ("Cc", "Cs", "Cn", "Zl", "Zp")


def _words(line: str, programs: tuple[str, ...]) -> Verdict:
    word, _, rest = line.partition(" ")
    rest = rest.strip()
    if word in programs:
        return "rejected" if rest else "taken"
    if rest:
        return "taken" if word.lower() == "stop" and rest in programs else "rejected"
    return _BARE.get(word) or _BARE.get(word.lower(), "rejected")


def _path(line: str, programs: tuple[str, ...]) -> Verdict:
    match [part.strip() for part in line.split("/") if part]:
        case ["r", power, angle]:
            return "moves" if _within(power, 0, 1) and _within(angle, -360, 360) else "rejected"
        case ["r", power, angle, cm, sensor, seconds]:
            fits = _within(power, 0, 1) and _within(angle, -360, 360) and _within(cm, 0, 769)
            return "moves" if fits and sensor.lower() in _SENSORS and _within(seconds, 0, 3600) else "rejected"
        case ["report", name]:
            return "taken" if name in _REPORTS else "rejected"
        case ["restart", name]:
            return "upset" if name in _UNITS else "rejected"
        case ["fault", device, _] | ["fault", device, _, "off"]:
            return "upset" if device in _DEVICES else "taken"
        case ["estop", _, *_]:
            return "estop"
        case [word]:
            return "taken" if word in programs else _BARE.get(word) or _BARE.get(word.lower(), "rejected")
    return "rejected"


def _within(text: str, low: float, high: float) -> bool:
    return bool(_NUMBER.fullmatch(text)) and low <= float(text) <= high
