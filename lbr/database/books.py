"""The tables in which lbr keeps books. Their rows are not part of a robot, and have no revisions."""

from typing import Annotated, Any, Literal

from msgspec import Meta, field

from lbr.database.past import ChangeRow
from lbr.database.rows import AuditRow, TokenRow
from lbr.database.trials import Trial
from lbr.messages.rows import COUNTED, NOW, Row


class SchemaStamp(Row, frozen=True, kw_only=True):
    """The revision of the schema, kept by the migrations in lbr/database/migrations. Not to be edited."""

    TABLE = "alembic_version"
    KEY = ("version_num",)
    SHARED = True

    version_num: Annotated[str, "a revision's identifier"]


class RevisionEntry(Row, frozen=True, kw_only=True):
    """Every change of rows that make the robot, kept by the triggers at the end of this file."""

    TABLE = "revision"
    KEY = ("id",)
    SHARED = True

    id: Annotated[int, COUNTED, "counts up, and is never used again"]
    table_name: Annotated[str, "which table"]
    row_key: Annotated[tuple[Any, ...], "the row's primary key (after an update, the new one)"]
    operation: Annotated[Literal["insert", "update", "delete"], "what was done to the row"]
    old_row: Annotated[dict[str, Any] | None, "the row before; NULL for an insert"] = None
    new_row: Annotated[dict[str, Any] | None, "the row after; NULL for a delete"] = None
    changed_at: Annotated[str, NOW, "when"]


class EventEntry(Row, frozen=True, kw_only=True):
    """Events; written by lbr, the oldest go when there are very many."""

    TABLE = "event"
    KEY = ("id",)
    SHARED = True

    id: Annotated[int, COUNTED, "counts up, and is never used again"]
    wall_ns: Annotated[int, Meta(ge=0), "nanoseconds since 1970 by the wall clock"]
    kind: Annotated[str, "started, stopped, crashed, refused, row_changed ..."]
    subject: Annotated[str, "the capability, or whom it is about"] = ""
    level: Annotated[Literal["info", "warning", "error"], "how much it matters"] = "info"
    text: Annotated[str, "one sentence"] = ""
    data: Annotated[dict[str, Any], "figures that belong to it"] = field(default_factory=dict)


class AdoptedEntry(Row, frozen=True, kw_only=True):
    """The row sets that ran, so that rows which change without an edit are noticed. Written by lbr."""

    TABLE = "adopted"
    KEY = ("revision",)
    SHARED = True

    revision: Annotated[int, "the last change of rows that was in it; 0: none"]
    hash: Annotated[str, "BLAKE2b over the rows that make robots"]
    wall_ns: Annotated[int, Meta(ge=0), "when it was adopted first, nanoseconds since 1970"]


BOOKS: tuple[type[Row], ...] = (
    SchemaStamp,
    TokenRow,
    RevisionEntry,
    ChangeRow,
    Trial,
    EventEntry,
    AuditRow,
    AdoptedEntry,
)
