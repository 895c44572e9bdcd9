"""Writes recorded messages for other programs: one MCAP file with an index, or a CSV table for each topic."""

import csv
import math
import re
from collections.abc import Callable, Iterable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import IO

import msgspec
from mcap.writer import CompressionType, Writer
from msgspec import Struct

from lbr import disk
from lbr.apps.recorder.recording.chunks import PICTURES, Channel, Message
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE
from lbr.names import first_free

Again = Callable[[], Iterable[Message]]
"""Returns the messages from the start; tables are read twice, first for their columns."""
LONGEST_LIST = 16
TIME, SECONDS = "time", "time_s"


class _Picture(Struct):
    """The field of a picture that is written into a file."""

    data: bytes


def to_mcap(path: Path, messages: Iterable[Message], library: str) -> int:
    """Write one MCAP file, whole or not at all; return its number of messages.

    Raise InputError if it cannot be written.
    """
    try:
        with disk.replacing(path) as draft, draft.open("wb") as file:
            return _write_mcap(file, messages, library)
    except OSError as err:
        raise InputError(f"{path} cannot be written: {err.strerror}") from err


def _write_mcap(file: IO[bytes], messages: Iterable[Message], library: str) -> int:
    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start(profile="lbr", library=library)
    schemas: dict[tuple[str, bytes], int] = {}
    channels: dict[Channel, int] = {}
    written = 0
    for message in messages:
        channel = message.channel
        if channel not in channels:
            key = channel.schema_name, channel.schema
            if channel.schema and key not in schemas:
                schemas[key] = writer.register_schema(channel.schema_name, "jsonschema", channel.schema)
            channels[channel] = writer.register_channel(channel.topic, channel.encoding, schemas.get(key, 0))
        writer.add_message(channels[channel], message.log_ns, message.data, message.publish_ns, message.sequence)
        written += 1
    writer.finish()
    return written


def to_csv(folder: Path, again: Again) -> dict[str, int]:
    """Write a table for each topic into a folder, and pictures as files beside them; return the rows of each.

    Columns are the fields, with a dot before nested ones. `time` and `time_s` are the recording's; a message's own
    fields of these names become `message.time` and `message.time_s`. Raise InputError if the files cannot be written.
    """
    columns: dict[str, dict[str, None]] = {}
    for message in again():
        columns.setdefault(message.topic, {}).update(dict.fromkeys(_fields(message)))
    counts: dict[str, int] = {}
    called = file_names(columns)
    files: dict[str, IO[str]] = {}
    tables: dict[str, csv.DictWriter[str]] = {}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for topic, names in columns.items():
            files[topic] = (folder / f"{called[topic]}.csv").open("w", newline="", encoding="utf-8")
            tables[topic] = csv.DictWriter(files[topic], [TIME, SECONDS, *names], extrasaction="ignore")
            tables[topic].writeheader()
        for message in again():
            if message.topic in tables:
                tables[message.topic].writerow(_row(message, folder, called[message.topic]))
                counts[message.topic] = counts.get(message.topic, 0) + 1
        for file in files.values():
            file.flush()
    except OSError as err:
        raise InputError(f"{folder} cannot be written: {err.strerror}") from err
    finally:
        for file in files.values():
            file.close()
    return counts


def file_names(topics: Iterable[str]) -> dict[str, str]:
    """Return the file name of each topic; a name that is taken gets a number."""
    names: dict[str, str] = {}
    for topic in topics:
        name = re.sub(r"[^A-Za-z0-9_.-]+", "_", topic).strip("_.") or "topic"
        names[topic] = first_free(name, lambda candidate: candidate in names.values(), "-")
    return names


def fields(value: object, name: str = "") -> Iterator[tuple[str, object]]:
    """Yield the path and value of each leaf in decoded JSON; long lists stay JSON."""
    if isinstance(value, dict) and value:
        for key, part in value.items():
            yield from fields(part, f"{name}.{key}" if name else str(key))
    elif (
        isinstance(value, list)
        and 0 < len(value) <= LONGEST_LIST
        and not any(isinstance(p, dict | list) for p in value)
    ):
        for index, part in enumerate(value):
            yield f"{name}.{index}", part
    elif isinstance(value, dict | list):
        yield name or "value", msgspec.json.encode(value).decode()
    else:
        yield name or "value", value


def decoded(message: Message) -> object:
    """Return a message as plain data; as text if it is not JSON."""
    try:
        return msgspec.json.decode(message.data)
    except UNREADABLE:
        return message.data.decode(errors="replace")


def _fields(one: Message) -> list[str]:
    if one.channel.schema_name == PICTURES:
        return ["file"]
    return [name for name, _value in _columns(one)]


def _columns(one: Message) -> Iterator[tuple[str, object]]:
    """Yield the column and value of each leaf of a message."""
    for name, value in fields(decoded(one)):
        yield (f"message.{name}" if name in {TIME, SECONDS} else name), value


def _row(message: Message, folder: Path, called: str) -> dict[str, object]:
    at = datetime.fromtimestamp(message.log_ns / 1e9, UTC)
    row: dict[str, object] = {TIME: at.isoformat(timespec="microseconds"), SECONDS: f"{message.log_ns / 1e9:.6f}"}
    if message.channel.schema_name == PICTURES:
        return row | {"file": _picture(message, folder, called, at)}
    return row | {name: _cell(value) for name, value in _columns(message)}


def _cell(value: object) -> object:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return ""
    return value


def picture_in(one: Message) -> bytes | None:
    """Return the bytes of the picture in a message, or None."""
    picture = one.read(_Picture)
    return picture.data if picture is not None else None


def _picture(one: Message, folder: Path, called: str, at: datetime) -> str:
    data = picture_in(one)
    if data is None:
        return ""
    name = f"{called}-{at:%Y%m%dT%H%M%S.%f}.jpg"
    (folder / name).write_bytes(data)
    return name
