"""Reads what is left of a recording: cut anywhere, with flipped bytes, of an older version or of another program."""

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
"""The end of a chunk's head: it finds one again behind damage."""
_BEFORE_SIGN = chunks.HEAD_BYTES - 4
_RECORD = struct.Struct("<BQ")
_LOOSE = {Opcode.SCHEMA, Opcode.CHANNEL}
_LAST_OPCODE = 15
MOST_METADATA = 1 << 20


class Damage(Struct):
    """The unreadable part of a file: how many places, and how many bytes."""

    places: int = 0
    bytes: int = 0
    whole: bool = False
    """It has its end: it was closed in order."""


class Recording:
    """One file, mapped: its chunks, and the messages in those that are wanted."""

    def __init__(self, path: Path, data: mmap.mmap | bytes) -> None:
        self.path = path
        self.damage = Damage()
        self.about: dict[str, str] = {}
        self._data = data
        self._size = len(data)
        self._contents = Contents()
        self._messages: list[tuple[int, bytes]] = []
        self.spans = list(self._scan())

    @property
    def start_ns(self) -> int:
        """When its first message was; 0 if it has none."""
        return min((span.start_ns for span in self.spans), default=0)

    @property
    def end_ns(self) -> int:
        """When its last message was."""
        return max((span.end_ns for span in self.spans), default=0)

    @property
    def empty(self) -> bool:
        """True if nothing of a recording was found: it is another file, or was cut before its first chunk's end."""
        return not (self.spans or self._messages)

    def messages(self, start_ns: int = 0, end_ns: int = 1 << 63) -> Iterator[Message]:
        """Yield the messages from one time to another, chunk by chunk; what is damaged is passed over and counted."""
        for span in self.spans:
            outside = span.end_ns < start_ns or span.start_ns > end_ns
            if outside and span is not self.spans[0]:  # the first one has the schemas
                continue
            try:
                plain = chunks.opened(self._data, span)
                for one in self._contents.read(plain):
                    if start_ns <= one.log_ns <= end_ns:
                        yield one
            except DamagedError:
                self._hurt(span.length)
        yield from self._unchunked(start_ns, end_ns)

    def chunks(self) -> Iterator[tuple[Span, Callable[[], list[Message]]]]:
        """Yield each chunk after the first, which repeats what was said before, with what reads it; damaged has none."""

        def read(span: Span) -> list[Message]:
            try:
                return list(self._contents.read(chunks.opened(self._data, span)))
            except DamagedError:
                self._hurt(span.length)
                return []

        for span in self.spans[1:]:
            yield span, partial(read, span)

    def _unchunked(self, start_ns: int, end_ns: int) -> Iterator[Message]:
        for _at, record in self._messages:
            try:
                yield from (one for one in self._contents.read(record) if start_ns <= one.log_ns <= end_ns)
            except DamagedError:
                self._hurt(len(record))

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
        """Return whether a record may begin here, or the file ends."""
        data, size = self._data, self._size
        if at == size:
            return True
        if at > size:
            return False
        return 0 < data[at] <= _LAST_OPCODE or bytes(data[at : at + len(MAGIC)]) == MAGIC or data[at] >= 0x80

    def _record_length(self, at: int) -> int:
        """Return the length of what is no chunk, 0 if it is nothing."""
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
                self._messages.append((at, bytes(self._data[at : at + length])))
            elif opcode == Opcode.METADATA:
                metadata = chunks.parsed(records.Metadata, body)
                if metadata.name == "lbr":
                    self.about = metadata.metadata
        except DamagedError:
            self._hurt(length)

    def _next(self, at: int) -> int | None:
        """Return where the next chunk begins, None after the last."""
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
    """Open a recording for the time of a `with`; InputError if it cannot be read at all."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):  # a pipe without a writer would be waited for
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
