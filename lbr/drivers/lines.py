"""Bytes in pieces of any size become lines of bounded length; at most one line is held."""

import re
from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RawLine:
    """A line without its end; an overlong line keeps only its beginning."""

    data: bytes
    overlong: bool

    @property
    def readable(self) -> str:
        """The beginning of the line in printable characters."""
        return repr(self.data[:40])[2:-1]


class LineSplitter:
    """Splits at `end`, a pattern of one byte, and keeps no more than `limit` bytes of a line."""

    def __init__(self, end: bytes, limit: int) -> None:
        self._end = re.compile(end)
        self._limit = limit
        self._line = bytearray()
        self._overlong = False

    def feed(self, data: bytes) -> Iterator[RawLine]:
        """Yield the lines that these bytes complete."""
        *ended, rest = self._end.split(data)
        for piece in ended:
            self._extend(piece)
            line = RawLine(bytes(self._line), self._overlong)
            self.reset()
            yield line
        self._extend(rest)

    def reset(self) -> None:
        """Forget the unfinished line."""
        self._line.clear()
        self._overlong = False

    @property
    def held_bytes(self) -> int:
        """Return how many bytes of an unfinished line it holds."""
        return len(self._line)

    def _extend(self, piece: bytes) -> None:
        room = self._limit - len(self._line)
        self._overlong = self._overlong or len(piece) > room
        self._line += piece[:room]
