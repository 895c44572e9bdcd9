"""A serial language of lines, with which a device is commanded and queried: bytes back into replies. No I/O.

Every command ends with CR. The device repeats it (the echo, if that is on), then answers `+`, `-` or `NAME=values`.
"""

import re
from dataclasses import dataclass

from lbr.drivers.lines import LineSplitter, RawLine

MAX_LINE_BYTES = 160


@dataclass(frozen=True, slots=True)
class Echo:
    """The device repeated a command (without its CR)."""

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


def query(name: str) -> bytes:
    """Return the query of a measured value, such as `?V`."""
    return b"?%s\r" % name.encode("ascii")


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

    def reset(self) -> None:
        """Forget the unfinished line."""
        self._lines.reset()

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


_SIGNS: dict[bytes, Ack | Nak] = {b"+": Ack(), b"-": Nak()}
_ECHO = re.compile(rb"[!?^~%#][A-Za-z]{1,7}(?: +-?\d{1,10})*")
_ECHO_THEN_SIGN = re.compile(rb"(?P<echo>[!^%][A-Za-z]{1,7}(?: +-?\d{1,10})*)(?P<sign>[+-])")
_ECHO_THEN_VALUE = re.compile(rb"(?P<echo>[?~](?P<name>[A-Za-z]{1,7})(?: +\d{1,3})*)(?P<value>(?P=name)=[ -~]*)")
_VALUE = re.compile(rb"(?P<name>[A-Z]{1,7})=(?P<text>[ -<>-~]*)")
