"""The output of the range boards: one JSON object per line, in centimetres. No I/O.

A board with more than the five sensors lists the others beside them, with a capital letter. The Arduino starts on `g`,
stops on `s` and remarks on every byte received; the Parallax board sends from its start on.
"""

from dataclasses import dataclass
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from lbr.drivers.lines import LineSplitter, RawLine
from lbr.drivers.ultrasonic import SENSORS, Board, UltrasonicSettings
from lbr.messages.sensing import Ranges, RangeStatus, ranges
from lbr.messages.unreadable import UNREADABLE

START = b"g\n"
FINISH = b"s\n"
MAX_LINE_BYTES = 512
TICKS_PER_S: dict[Board, float] = {"arduino": 1000.0, "parallax": 80_000_000.0}
NO_SENSOR = -1
TURNS = ("forward", "left", "right", "back")
"""The order in which they measure; further sensors come after these."""
ECHO_S_PER_CM, NO_ECHO_S = 58e-6, 0.1
LINE_S = 0.015
"""The time of a line's bytes at 115200 baud, and half a round of the driver."""
Told = Annotated[
    str, Meta(pattern="^[A-Z][a-z0-9_]{0,39}$(?!\\n)", description="a sensor's name with a capital letter")
]
Number = Annotated[int, Meta(ge=-(2**31), lt=2**32, description="what a board of 32 bits can count to")]


class Frame(Struct, frozen=True):
    """One measuring cycle as the board wrote it; `others` are sensors beyond the five, by name."""

    forward: int
    left: int
    right: int
    back: int
    bottom: int
    deltat: int
    others: dict[str, int] = {}


@dataclass(frozen=True, slots=True)
class BadLine:
    """A line that is neither a frame nor a remark of the board; `text` is its beginning."""

    text: str


class _Line(Struct, frozen=True, forbid_unknown_fields=True):
    ranges: dict[Told, Number] = msgspec.field(name="Ranges")


class LineParser:
    """Turns bytes, in any pieces, into frames. `lines` holds one at most; the rest of a forgotten one is bad."""

    def __init__(self) -> None:
        self.lines = LineSplitter(rb"\n", MAX_LINE_BYTES)

    def feed(self, data: bytes) -> list[Frame | BadLine]:
        """Return the frames and the bad lines that these bytes complete."""
        found = (BadLine(line.readable) if line.overlong else parse_line(line.data) for line in self.lines.feed(data))
        return [each for each in found if each is not None]


def parse_line(line: bytes) -> Frame | BadLine | None:
    """Return the frame in a line; None for an empty line or the board's remark on a received byte."""
    line = line.strip()
    if not line or (line.startswith(b"received:") and b"{" not in line):
        return None
    try:
        told = {name.lower(): number for name, number in _decoder.decode(line).ranges.items()}
        known = {name: told.pop(name) for name in (*SENSORS, "deltat")}
        return Frame(**known, others=told)
    except (KeyError, OverflowError, *UNREADABLE):
        return BadLine(RawLine(line, overlong=False).readable)


def to_ranges(frame: Frame, settings: UltrasonicSettings) -> Ranges:
    """Return a frame in metres, with null and a status for every sensor that did not measure."""
    metres: dict[str, float | None] = {}
    status: dict[str, RangeStatus] = {}
    told: dict[str, int] = {name: getattr(frame, name) for name in SENSORS}
    for name, cm in (told | frame.others).items():
        status[name] = "missing" if name in settings.absent else classify(cm, settings)
        metres[name] = cm / 100.0 if status[name] == "ok" else None
    cycle_s = frame.deltat / TICKS_PER_S[settings.board] if frame.deltat > 0 else None
    return ranges(metres, status, cycle_s, ages_s(frame))


def near(measured: Ranges, before: Ranges, still_cm: int) -> bool:
    """Return whether two measurements are the same, but for noise."""
    pairs = [(measured.metres(name), before.metres(name)) for name in measured.status]
    same = all(a is None or b is None or round(abs(a - b) * 100) <= still_cm for a, b in pairs)
    return same and measured.status == before.status


def ages_s(frame: Frame) -> dict[str, float]:
    """Return the age of each reading: sensors take turns, each for the time of its echo, and the line follows them."""
    turns = {name: getattr(frame, name) for name in TURNS} | frame.others
    ages, age_s = {}, LINE_S
    for name, cm in reversed(turns.items()):
        age_s += cm * ECHO_S_PER_CM if cm > 0 else NO_ECHO_S
        ages[name] = round(age_s, 3)
    return dict(reversed(ages.items()))


def classify(cm: int, settings: UltrasonicSettings) -> RangeStatus:
    """Return the meaning of a sensor's number."""
    if cm == NO_SENSOR:
        return "missing"
    if settings.min_cm <= cm < settings.over_range_cm:
        return "ok"
    if settings.over_range_cm <= cm <= settings.max_cm:
        return "over_range"
    return "invalid"  # 0 is the sensor's error; other numbers out of bounds are implausible


_decoder = msgspec.json.Decoder(_Line)
