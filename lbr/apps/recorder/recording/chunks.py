"""The bytes of a recording: schemas, channels and messages, packed into independent chunks. Pure.

Each chunk repeats the channels of its messages, so that an earlier chunk may be lost. MCAP: https://mcap.dev/spec
"""

import mmap
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping
from io import BytesIO
from typing import TypeVar

import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.stream_reader import get_chunk_data_stream
from msgspec import Struct

from lbr.apps.recorder.recording.decoding import read_or_none

MAGIC = b"\x89MCAP0\r\n"
MOST_BYTES = 64 << 20
"""The largest chunk before compression; a larger one is damage.

A second of everything with cameras is a tenth of that.
"""
PICTURES = "foxglove.CompressedImage"
"""The name of a picture's schema, by which viewers of recordings know it."""
LEVEL = 1
COMPRESSION = "zstd"
_MESSAGE = struct.Struct("<BQHIQQ")
_RECORD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_CHUNK_HEAD = struct.Struct("<QQQII")
HEAD_BYTES = _RECORD.size + _CHUNK_HEAD.size

T = TypeVar("T")
R = TypeVar("R", records.Chunk, records.Schema, records.Channel, records.Metadata)


class DamagedError(ValueError):
    """Bytes that are not a whole record."""


class Channel(Struct, frozen=True):
    """A recorded stream: its topic below the robot, its encoding, and its schema at that time."""

    topic: str
    encoding: str = "json"
    schema_name: str = ""
    schema: bytes = b""


class Message(Struct, frozen=True, gc=False):
    """One message: its times by the recording's clock and by its sender's, its number, and its bytes."""

    channel: Channel
    log_ns: int
    publish_ns: int
    sequence: int
    data: bytes

    @property
    def topic(self) -> str:
        """The topic below the robot."""
        return self.channel.topic

    def read(self, kind: type[T]) -> T | None:
        """Return its data as this type; None if it is malformed."""
        return read_or_none(self.data, kind)


class Channels:
    """Numbers channels, and keeps their records.

    A stream whose schema changes becomes another channel of the same topic.
    """

    def __init__(self) -> None:
        self._ids: dict[Channel, int] = {}
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._channel_bytes: dict[int, bytes] = {}
        self._schema_bytes: list[bytes] = []

    def number(self, channel: Channel) -> int:
        """Return the number of a channel; a new channel gets the next one."""
        number = self._ids.get(channel)
        if number is None:
            number = self._ids[channel] = len(self._ids) + 1
            schema = self._schema(channel) if channel.schema else 0
            record = records.Channel(
                id=number, topic=channel.topic, message_encoding=channel.encoding, metadata={}, schema_id=schema
            )
            self._channel_bytes[number] = _bytes_of(record)
        return number

    @property
    def schemas(self) -> bytes:
        """The records of all schemas."""
        return b"".join(self._schema_bytes)

    def of(self, numbers: Iterable[int]) -> bytes:
        """Return the records of channels."""
        return b"".join(self._channel_bytes[number] for number in numbers)

    def _schema(self, channel: Channel) -> int:
        key = channel.schema_name, channel.schema
        if key not in self._schemas:
            self._schemas[key] = number = len(self._schemas) + 1
            encoding = "jsonschema"
            self._schema_bytes.append(
                _bytes_of(records.Schema(id=number, data=channel.schema, encoding=encoding, name=channel.schema_name))
            )
        return self._schemas[key]


def message(number: int, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> bytes:
    """Return the record of a message."""
    return _MESSAGE.pack(5, 22 + len(data), number, sequence & 0xFFFFFFFF, log_ns, publish_ns) + data


def chunk(parts: Iterable[bytes], start_ns: int, end_ns: int) -> bytes:
    """Return the record of a chunk of these records, compressed."""
    plain = b"".join(parts)
    packed = zstandard.ZstdCompressor(level=LEVEL).compress(plain)  # not shared: two threads write files
    return _bytes_of(
        records.Chunk(
            compression=COMPRESSION,
            data=packed,
            message_start_time=max(0, start_ns),
            message_end_time=max(0, end_ns),
            uncompressed_crc=zlib.crc32(plain),
            uncompressed_size=len(plain),
        )
    )


def beginning(library: str, about: Mapping[str, str]) -> bytes:
    """Return the first bytes of a recording."""
    builder = RecordBuilder()
    records.Header(profile="lbr", library=library).write(builder)
    records.Metadata(name="lbr", metadata=dict(about)).write(builder)
    return MAGIC + bytes(builder.end())


def ending() -> bytes:
    """Return the last bytes of a finished recording; it has no index, which readers do not need."""
    builder = RecordBuilder()
    records.DataEnd(data_section_crc=0).write(builder)
    records.Footer(summary_start=0, summary_offset_start=0, summary_crc=0).write(builder)
    return bytes(builder.end()) + MAGIC


class Span(Struct, frozen=True):
    """A chunk in a file: its place, its length, and the times of its first and last message."""

    at: int
    length: int
    start_ns: int
    end_ns: int


def head(data: mmap.mmap | bytes, at: int, size: int) -> Span | None:
    """Return the chunk that begins at this place; None if none does, or it does not fit into the file."""
    if at + HEAD_BYTES > size or data[at] != Opcode.CHUNK:
        return None
    _, length = _RECORD.unpack_from(data, at)
    start_ns, end_ns, plain, _crc, name = _CHUNK_HEAD.unpack_from(data, at + _RECORD.size)
    if length < _CHUNK_HEAD.size + 8 or at + _RECORD.size + length > size or plain > MOST_BYTES or name > 8:
        return None
    if at + HEAD_BYTES + name + 8 > size:
        return None
    (packed,) = struct.unpack_from("<Q", data, at + HEAD_BYTES + name)
    if length != _CHUNK_HEAD.size + name + 8 + packed:  # a damaged length would reach into the next chunk
        return None
    return Span(at, _RECORD.size + length, start_ns, end_ns)


class _Body(ReadDataStream):
    """The bytes of one record; raises EndOfFile where it is cut."""

    def __init__(self, body: bytes) -> None:
        super().__init__(BytesIO(body))

    def read(self, length: int) -> bytes:
        """Return exactly `length` bytes."""
        data = super().read(length)
        if len(data) != length:
            raise EndOfFile
        return data


def opened(data: mmap.mmap | bytes, span: Span) -> bytes:
    """Unpack the records of a chunk; raise DamagedError if its checksum or size is wrong."""
    chunk = parsed(records.Chunk, data[span.at + _RECORD.size : span.at + span.length])
    try:
        stream, size = get_chunk_data_stream(chunk, validate_crc=True)
        plain = stream.read(size)
    except (zstandard.ZstdError, McapError, RuntimeError, ValueError, MemoryError) as err:
        raise DamagedError(f"a chunk cannot be unpacked: {err}") from err
    if size != chunk.uncompressed_size:
        raise DamagedError("a chunk has another size than its header states")
    return plain


def parsed(kind: type[R], body: bytes) -> R:
    """Parse a record of a kind; raise DamagedError if it is cut or damaged."""
    try:
        record: R = kind.read(_Body(body))
    except (EndOfFile, UnicodeDecodeError) as err:
        raise DamagedError(f"a {kind.__name__} is damaged: {err}") from err
    return record


class Contents:
    """Reads records in sequence, and keeps their schemas and channels for the next chunk."""

    def __init__(self) -> None:
        self.schemas: dict[int, tuple[str, bytes]] = {}
        self.channels: dict[int, Channel] = {}
        self._raw: dict[int, records.Channel] = {}
        self._declared: dict[tuple[int, bytes], bytes] = {}

    def read(self, plain: bytes) -> Iterator[Message]:
        """Yield the messages of a chunk; raise DamagedError where its records are cut."""
        at, size = 0, len(plain)
        while at < size:
            if at + _RECORD.size > size:
                raise DamagedError("a record is cut")
            opcode, length = _RECORD.unpack_from(plain, at)
            at += _RECORD.size
            if at + length > size:
                raise DamagedError("a record is cut")
            if opcode == Opcode.MESSAGE:
                if length < _MESSAGE_HEAD.size:
                    raise DamagedError("a message is cut")
                number, sequence, log_ns, publish_ns = _MESSAGE_HEAD.unpack_from(plain, at)
                known = self.channels.get(number)
                if known is not None:
                    data = plain[at + _MESSAGE_HEAD.size : at + length]
                    yield Message(known, log_ns, publish_ns, sequence, data)
            elif opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
                self.declare(opcode, plain[at : at + length])
            at += length

    def declare(self, opcode: int, body: bytes) -> None:
        """Store a schema or channel; raise DamagedError if it is broken."""
        number = opcode, body[:2]
        if self._declared.get(number) == body:
            return
        if opcode == Opcode.SCHEMA:
            schema = parsed(records.Schema, body)
            self.schemas[schema.id] = schema.name, schema.data
            for channel in [one for one in self._raw.values() if one.schema_id == schema.id]:
                self._put(channel)
        else:
            channel = parsed(records.Channel, body)
            self._raw[channel.id] = channel
            self._put(channel)
        self._declared[number] = body

    def _put(self, channel: records.Channel) -> None:
        name, data = self.schemas.get(channel.schema_id, ("", b""))
        self.channels[channel.id] = Channel(channel.topic, channel.message_encoding, name, data)


def _bytes_of(record: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
