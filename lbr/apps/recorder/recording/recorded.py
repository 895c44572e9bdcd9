"""The description of a robot for a recorder: the reports `streams` and `rows`."""

from msgspec import Raw, Struct

from lbr.messages.schema import JsonObject


class RecordedStream(Struct, frozen=True, kw_only=True):
    """A stream: its key, and its message's name and schema; empty: not known."""

    key: str
    source: str
    message: str
    picture: bool
    schema: Raw


class RecordedStreams(Struct, frozen=True, kw_only=True):
    """All streams of a revision's plan, setpoints included; `programs` are the names of external commands."""

    revision: int
    streams: tuple[RecordedStream, ...]
    programs: tuple[str, ...] = ()


class RecordedRows(Struct, frozen=True, kw_only=True):
    """The rows of a revision by table, without tokens, and the facts for `why`."""

    revision: int
    facts: Raw
    tables: dict[str, list[JsonObject]] = {}
