"""The bytes of a recording: schemas, channels and messages, packed into chunks that stand by themselves. Pure.

Each chunk has the channels of its messages again, so that a chunk before it may be lost. MCAP: https://mcap.dev/spec
"""

import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from msgspec import Struct

MAGIC = b"\x89MCAP0\r\n"
MOST_BYTES = 64 << 20
"""Of a chunk as it was before it was compressed: more is damage. A second of everything with cameras is a tenth of
that."""
LEVEL = 1
COMPRESSION = "zstd"
_MESSAGE = struct.Struct("<BQHIQQ")
_RECORD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_CHUNK_HEAD = struct.Struct("<QQQII")
HEAD_BYTES = _RECORD.size + _CHUNK_HEAD.size


class DamagedError(ValueError):
    """Bytes that are no whole record."""


class Channel(Struct, frozen=True):
    """A stream in a recording: its topic below the robot, how its messages are written, and its schema as it was
    then."""

    topic: str
    encoding: str = "json"
    schema_name: str = ""
    schema: bytes = b""


class Message(Struct, frozen=True, gc=False):
    """One message: when it was published by the recording's clock and by its sender's, its number, and its bytes."""

    channel: Channel
    log_ns: int
    publish_ns: int
    sequence: int
    data: bytes

    @property
    def topic(self) -> str:
        """The topic below the robot."""
        return self.channel.topic


class Channels:
    """Numbers channels, and keeps their bytes: a stream whose schema changes is another channel of the same topic."""

    def __init__(self) -> None:
        self._ids: dict[Channel, int] = {}
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._channel_bytes: dict[int, bytes] = {}
        self._schema_bytes: list[bytes] = []

    def number(self, channel: Channel) -> int:
        """Return the number of a channel, a new one if need be."""
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
    packed = zstandard.ZstdCompressor(level=LEVEL).compress(plain)  # one of its own: two files are written at once
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
    """Return how a recording begins."""
    builder = RecordBuilder()
    records.Header(profile="lbr", library=library).write(builder)
    records.Metadata(name="lbr", metadata=dict(about)).write(builder)
    return MAGIC + bytes(builder.end())


def ending() -> bytes:
    """Return how a whole recording ends: without an index, which readers do not need."""
    builder = RecordBuilder()
    records.DataEnd(data_section_crc=0).write(builder)
    records.Footer(summary_start=0, summary_offset_start=0, summary_crc=0).write(builder)
    return bytes(builder.end()) + MAGIC


class Span(Struct, frozen=True):
    """A chunk in a file: where it is, how long it is, and from when to when its messages are."""

    at: int
    length: int
    start_ns: int
    end_ns: int


def head(data: Any, at: int, size: int) -> Span | None:
    """Return the chunk that begins here, if there is one that fits into a file of this size."""
    if at + HEAD_BYTES > size or data[at] != Opcode.CHUNK:
        return None
    _, length = _RECORD.unpack_from(data, at)
    start_ns, end_ns, plain, _crc, name = _CHUNK_HEAD.unpack_from(data, at + _RECORD.size)
    if length < _CHUNK_HEAD.size + 8 or at + _RECORD.size + length > size or plain > MOST_BYTES or name > 8:
        return None
    if at + HEAD_BYTES + name + 8 > size:
        return None
    (packed,) = struct.unpack_from("<Q", data, at + HEAD_BYTES + name)
    if length != _CHUNK_HEAD.size + name + 8 + packed:  # a damaged length would lead into the next chunk
        return None
    return Span(at, _RECORD.size + length, start_ns, end_ns)


def opened(data: Any, span: Span) -> bytes:
    """Return the records in a chunk; DamagedError if it is not as it was written."""
    _start, _end, plain_size, crc, name_size = _CHUNK_HEAD.unpack_from(data, span.at + _RECORD.size)
    place = span.at + HEAD_BYTES
    name = bytes(data[place : place + name_size])
    (packed_size,) = struct.unpack_from("<Q", data, place + name_size)
    place += name_size + 8
    if place + packed_size != span.at + span.length:
        raise DamagedError("a chunk's lengths do not agree")
    packed = bytes(data[place : place + packed_size])
    try:
        plain = _unpacked(name, packed, plain_size)
    except (zstandard.ZstdError, RuntimeError, ValueError, MemoryError) as err:
        raise DamagedError(f"a chunk cannot be unpacked: {err}") from err
    if len(plain) != plain_size or (crc and zlib.crc32(plain) != crc):
        raise DamagedError("a chunk's checksum is wrong")
    return plain


def _unpacked(name: bytes, packed: bytes, size: int) -> bytes:
    if name == b"zstd":
        return zstandard.ZstdDecompressor().decompress(packed, max_output_size=max(size, 1)) if packed else b""
    if name == b"lz4":
        import lz4.frame

        return bytes(lz4.frame.decompress(packed))  # type: ignore[attr-defined]  # it has no types
    if name == b"":
        return packed
    raise DamagedError(f"a chunk is packed by '{name.decode(errors='replace')}', which is not known here")


class Contents:
    """Reads records one after the other; what it has heard of schemas and channels it keeps for the next chunk."""

    def __init__(self) -> None:
        self.schemas: dict[int, tuple[str, bytes]] = {}
        self.channels: dict[int, Channel] = {}
        self._raw: dict[int, records.Channel] = {}

    def read(self, plain: bytes) -> Iterator[Message]:
        """Yield the messages of a chunk; DamagedError where it is no sequence of records."""
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
        """Take a schema or a channel; DamagedError if it is broken."""
        try:
            if opcode == Opcode.SCHEMA:
                self._take_schema(body)
            else:
                self._take_channel(body)
        except (struct.error, UnicodeDecodeError, IndexError) as err:
            raise DamagedError(f"a declaration is damaged: {err}") from err

    def _take_schema(self, body: bytes) -> None:
        (number,) = struct.unpack_from("<H", body)
        name, at = _text(body, 2)
        _encoding, at = _text(body, at)
        (length,) = struct.unpack_from("<I", body, at)
        self.schemas[number] = name, body[at + 4 : at + 4 + length]
        for channel in [one for one in self._raw.values() if one.schema_id == number]:
            self._put(channel)

    def _take_channel(self, body: bytes) -> None:
        number, schema = struct.unpack_from("<HH", body)
        topic, at = _text(body, 4)
        encoding, _at = _text(body, at)
        if number in self._raw and (self._raw[number].topic, self._raw[number].schema_id) == (topic, schema):
            return
        self._raw[number] = records.Channel(
            id=number, topic=topic, message_encoding=encoding, metadata={}, schema_id=schema
        )
        self._put(self._raw[number])

    def _put(self, channel: records.Channel) -> None:
        name, data = self.schemas.get(channel.schema_id, ("", b""))
        self.channels[channel.id] = Channel(channel.topic, channel.message_encoding, name, data)


def _text(body: bytes, at: int) -> tuple[str, int]:
    (length,) = struct.unpack_from("<I", body, at)
    end = at + 4 + length
    if end > len(body):
        raise IndexError("a text is cut")
    return body[at + 4 : end].decode(), end


def _bytes_of(record: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
