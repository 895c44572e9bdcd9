"""A recorder's knowledge of a robot, by the reports `streams` and `rows`."""

from typing import Any

from msgspec import Raw, Struct


class RecordedStream(Struct, frozen=True, kw_only=True):
    """A stream: the key on which it is published, the name of its message and the schema of that; empty: not known."""

    key: str
    source: str
    message: str
    picture: bool
    schema: Raw


class RecordedStreams(Struct, frozen=True, kw_only=True):
    """All that is published, setpoints too, of the plan of a revision; `programs` are external commands by name."""

    revision: int
    streams: tuple[RecordedStream, ...]
    programs: tuple[str, ...] = ()


class RecordedRows(Struct, frozen=True, kw_only=True):
    """The rows of a revision by table, without tokens, and the facts by which `why` explains them."""

    revision: int
    facts: Raw
    tables: dict[str, list[dict[str, Any]]] = {}
