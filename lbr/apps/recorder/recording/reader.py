"""Reads recordings that may be cut, damaged, of an older version or of another program."""

import mmap
import os
import stat
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from mcap import records
from mcap.opcode import Opcode
from msgspec import Struct

from lbr.apps.recorder.recording import chunks
from lbr.apps.recorder.recording.chunks import MAGIC, Contents, DamagedError, Message, Span
from lbr.errors import InputError

_SIGNS = (b"\x04\x00\x00\x00zstd", b"\x03\x00\x00\x00lz4", b"\x00\x00\x00\x00")
"""The last bytes of a chunk's head, by which the next chunk is found after damage."""
_BEFORE_SIGN = chunks.HEAD_BYTES - 4
_RECORD = struct.Struct("<BQ")
_LOOSE = {Opcode.SCHEMA, Opcode.CHANNEL}
_LAST_OPCODE = 15
MOST_METADATA = 1 << 20


class Damage(Struct):
    """The unreadable part of a file: the number of places, and of bytes."""

    places: int = 0
    bytes: int = 0
    whole: bool = False
    """The file was finished in order."""


class Recording:
    """One mapped file: its chunks, and their messages on demand."""

    def __init__(self, path: Path, data: mmap.mmap | bytes) -> None:
        self.path = path
        self.damage = Damage()
        self.about: dict[str, str] = {}
        self._data = data
        self._size = len(data)
        self._contents = Contents()
        self._messages: list[bytes] = []
        self.spans = list(self._scan())

    @property
    def end_ns(self) -> int:
        """The time of its last message; 0 without messages."""
        return max((span.end_ns for span in self.spans), default=0)

    @property
    def empty(self) -> bool:
        """True if the file has no messages: it is another sort of file, or is cut within its first chunk."""
        return not (self.spans or self._messages)

    def messages(self, start_ns: int = 0, end_ns: int = 1 << 63) -> Iterator[Message]:
        """Yield the messages of a time span, chunk by chunk; damaged parts are skipped and counted."""
        for span in self.spans:
            outside = span.end_ns < start_ns or span.start_ns > end_ns
            if not outside or span is self.spans[0]:  # the first chunk has the schemas
                yield from (one for one in self._chunk(span) if start_ns <= one.log_ns <= end_ns)
        for record in self._messages:
            yield from (one for one in self._read(record, len(record)) if start_ns <= one.log_ns <= end_ns)

    def chunks(self) -> Iterator[tuple[Span, Callable[[], Iterator[Message]]]]:
        """Yield each chunk after the first, which repeats older messages, with a function that reads its messages."""
        for span in self.spans[1:]:
            yield span, partial(self._chunk, span)

    def _chunk(self, span: Span) -> Iterator[Message]:
        try:
            plain = chunks.opened(self._data, span)
        except DamagedError:
            self._hurt(span.length)
            return
        yield from self._read(plain, span.length)

    def _read(self, plain: bytes, length: int) -> Iterator[Message]:
        """Yield the messages of a part of the file that has this length, up to a damaged place."""
        try:
            yield from self._contents.read(plain)
        except DamagedError:
            self._hurt(length)

    def _scan(self) -> Iterator[Span]:
        data, size, at = self._data, self._size, len(MAGIC)
        if bytes(data[: len(MAGIC)]) != MAGIC:
            self._hurt(min(size, len(MAGIC)))
            at = 0
        while at < size:
            if bytes(data[at : at + len(MAGIC)]) == MAGIC and at + len(MAGIC) == size:
                self.damage.whole = True
                return
            span = chunks.head(data, at, size) if data[at] == Opcode.CHUNK else None
            if span is not None and (self._follows(span.at + span.length) or _opens(data, span)):
                yield span
                at += span.length
                continue
            length = self._record_length(at) if data[at] != Opcode.CHUNK else 0
            if length and self._follows(at + length):
                self._take(at, length)
                at += length
                continue
            next_at = self._next(at + 1)
            self._hurt((next_at if next_at is not None else size) - at)
            if next_at is None:
                return
            at = next_at

    def _follows(self, at: int) -> bool:
        """Return whether a record or the file's end may be at this place."""
        data, size = self._data, self._size
        if at == size:
            return True
        if at > size:
            return False
        return 0 < data[at] <= _LAST_OPCODE or bytes(data[at : at + len(MAGIC)]) == MAGIC or data[at] >= 0x80

    def _record_length(self, at: int) -> int:
        """Return the length of a record other than a chunk; 0 if there is no valid one."""
        if at + _RECORD.size > self._size:
            return 0
        opcode, length = _RECORD.unpack_from(self._data, at)
        known = 0 < opcode <= _LAST_OPCODE
        if not known or length > MOST_METADATA or at + _RECORD.size + length > self._size:
            return 0
        return _RECORD.size + int(length)

    def _take(self, at: int, length: int) -> None:
        opcode = self._data[at]
        body = bytes(self._data[at + _RECORD.size : at + length])
        try:
            if opcode in _LOOSE:
                self._contents.declare(opcode, body)
            elif opcode == Opcode.MESSAGE:
                self._messages.append(bytes(self._data[at : at + length]))
            elif opcode == Opcode.METADATA:
                metadata = chunks.parsed(records.Metadata, body)
                if metadata.name == "lbr":
                    self.about = metadata.metadata
        except DamagedError:
            self._hurt(length)

    def _next(self, at: int) -> int | None:
        """Return where the next intact chunk begins, or None."""
        starts = []
        for sign in _SIGNS[:2]:
            place = self._data.find(sign, at + _BEFORE_SIGN)
            while place >= 0:
                start = place - _BEFORE_SIGN
                span = chunks.head(self._data, start, self._size)
                if span is not None and _opens(self._data, span):
                    starts.append(start)
                    break
                place = self._data.find(sign, place + 1)
        return min(starts, default=None)

    def _hurt(self, length: int) -> None:
        self.damage.places += 1
        self.damage.bytes += length


@contextmanager
def opened(path: Path) -> Iterator[Recording]:
    """Open a recording for a `with`; raise InputError if the file cannot be read."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):  # opening a pipe without a writer would block
            raise InputError(f"{path} cannot be read: it is not a file")
        with path.open("rb") as file:
            if os.fstat(file.fileno()).st_size == 0:
                yield Recording(path, b"")
                return
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
                yield Recording(path, data)
    except OSError as err:
        raise InputError(f"{path} cannot be read: {err.strerror}") from err


def _opens(data: mmap.mmap | bytes, span: Span) -> bool:
    try:
        chunks.opened(data, span)
    except (DamagedError, struct.error):
        return False
    return True
