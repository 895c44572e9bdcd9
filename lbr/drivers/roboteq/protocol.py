"""The Roboteq's serial language: commands out, a stream of bytes back into replies. No I/O.

Every command ends with CR. The controller repeats it (the echo, if that is on), then answers `+`, `-` or `NAME=values`.
"""

import re
from dataclasses import dataclass

from lbr.drivers.lines import LineSplitter, RawLine

FULL_SCALE = 1000
MAX_LINE_BYTES = 160
STOP = b"!M 0 0\r"
EMERGENCY_STOP = b"!EX\r"
ACKNOWLEDGED = b"+\r"
RELEASE = b"!MG\r"


@dataclass(frozen=True, slots=True)
class Echo:
    """The controller repeated a command (without its CR)."""

    command: bytes


@dataclass(frozen=True, slots=True)
class Ack:
    """`+`: the command is in force."""


@dataclass(frozen=True, slots=True)
class Nak:
    """`-`: the command was refused."""


@dataclass(frozen=True, slots=True)
class Value:
    """The answer to a query or to reading a setting, not yet interpreted."""

    name: str
    text: str


@dataclass(frozen=True, slots=True)
class Noise:
    """An unknown line; `text` is its beginning."""

    text: str


Reply = Echo | Ack | Nak | Value | Noise


def motors(channel1: int, channel2: int) -> bytes:
    """Return `!M`: both channels at once, each within full scale."""
    return b"!M %d %d\r" % (_checked(channel1), _checked(channel2))


def query(name: str) -> bytes:
    """Return the query of a measured value, such as `?V`."""
    return b"?%s\r" % name.encode("ascii")


def read_setting(name: str) -> bytes:
    """Return the query of a setting, such as `~RWD`."""
    return b"~%s\r" % name.encode("ascii")


def write_setting(name: str, value: int) -> bytes:
    """Return the change of a setting, such as `^RWD 200`; it is lost at the next reset."""
    return b"^%s %d\r" % (name.encode("ascii"), value)


def is_inertial_unit(identity: str) -> bool:
    """Return whether a firmware or model is that of a RIOX, which speaks the same language but drives no motor."""
    return "riox" in identity.lower()


class ReplyParser:
    """Turns bytes, in pieces of any size, into replies; it holds at most one line."""

    def __init__(self) -> None:
        self._lines = LineSplitter(rb"[\r\n]", MAX_LINE_BYTES)

    def feed(self, data: bytes) -> list[Reply]:
        """Return the replies that these bytes complete."""
        replies: list[Reply] = []
        for line in self._lines.feed(data):
            replies += [Noise(line.readable)] if line.overlong else parse_line(line.data)
        return replies

    @property
    def held_bytes(self) -> int:
        """Return how many bytes of an unfinished line it holds."""
        return self._lines.held_bytes


def parse_line(line: bytes) -> list[Reply]:
    """Return the content of one line: nothing, a reply, or an echo joined with its reply."""
    line = line.strip(b" \t\x00")
    if not line:
        return []
    if line in _SIGNS:
        return [_SIGNS[line]]
    if merged := _ECHO_THEN_VALUE.fullmatch(line):
        return [Echo(merged["echo"]), *_value(merged["value"])]
    if merged := _ECHO_THEN_SIGN.fullmatch(line):
        return [Echo(merged["echo"]), _SIGNS[merged["sign"]]]
    if _ECHO.fullmatch(line):
        return [Echo(line)]
    return _value(line)


def _value(line: bytes) -> list[Reply]:
    match = _VALUE.fullmatch(line)
    if match is None:
        return [Noise(RawLine(line, overlong=False).readable)]
    return [Value(match["name"].decode("ascii"), match["text"].decode("ascii"))]


def _checked(value: int) -> int:
    if not -FULL_SCALE <= value <= FULL_SCALE:
        raise ValueError(f"motor value {value} is outside -{FULL_SCALE}..{FULL_SCALE}")
    return value


_SIGNS: dict[bytes, Ack | Nak] = {b"+": Ack(), b"-": Nak()}
_ECHO = re.compile(rb"[!?^~%#][A-Za-z]{1,7}(?: +-?\d{1,10})*")
_ECHO_THEN_SIGN = re.compile(rb"(?P<echo>[!^%][A-Za-z]{1,7}(?: +-?\d{1,10})*)(?P<sign>[+-])")
_ECHO_THEN_VALUE = re.compile(rb"(?P<echo>[?~](?P<name>[A-Za-z]{1,7})(?: +\d{1,3})*)(?P<value>(?P=name)=[ -~]*)")
_VALUE = re.compile(rb"(?P<name>[A-Z]{1,7})=(?P<text>[ -<>-~]*)")
