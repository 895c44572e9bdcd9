"""Recognises the lines that stop a robot, however they came to be typed. Pure."""

import re
import unicodedata

from lbr.console.printable import MAX_LINE, bare
from lbr.messages.plain import one_line

STOPS = frozenset({"s", "stop", "estop"})
EMERGENCY = "estop"
SLASHES = "/\uff0f"
LONGEST = MAX_LINE - 16
_REMAINS = re.compile(r"(?:\x1b?\[[0-9;?<]*[A-Za-z~]?)+\s*\Z")
"""The rest of a terminal's sequence whose beginning the line editor has consumed: no key types it."""
_SLASH = re.compile(f"[{SLASHES}]")


def stop_in(line: str | bytes) -> str:
    """Return the stop in a line, as each robot knows it; empty for a line without one.

    Letters may be capitals, or wide ones of another script's keyboard. Blanks, slashes and invisible characters may
    surround them, and remains of a terminal's sequences may follow. An emergency stop may have a reason:
    `/estop/REASON`.
    """
    text = line.decode(errors="replace") if isinstance(line, bytes) else line
    word, *more = _SLASH.split(bare(_REMAINS.sub("", text[:LONGEST]), SLASHES)[:LONGEST], maxsplit=1)
    word = unicodedata.normalize("NFKC", bare(word)).lower()
    said = bare("".join(more))
    if word not in STOPS or (said and word != EMERGENCY):
        return ""
    reason = one_line(said).strip()
    return f"/{word}/{reason}" if reason else word


def is_stop(line: str | bytes) -> bool:
    """Return whether a line stops the robot."""
    return bool(stop_in(line))
