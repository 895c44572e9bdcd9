"""The tables in which lbr keeps books. Their rows are not part of a robot, and have no revisions."""

from typing import Annotated, Any, Literal

from msgspec import Meta, field

from lbr.database.past import ChangeRow
from lbr.database.rows import AuditRow, TokenRow
from lbr.database.trials import Trial
from lbr.messages.rows import COUNTED, NOW, Row


class SchemaStamp(Row, frozen=True, kw_only=True):
    """The revision of the schema, written by the migrations in lbr/database/migrations. Do not edit it."""

    TABLE = "alembic_version"
    KEY = ("version_num",)
    SHARED = True

    version_num: Annotated[str, "a revision's identifier"]


class RevisionEntry(Row, frozen=True, kw_only=True):
    """Every change of a row, written by the triggers at the end of this file."""

    TABLE = "revision"
    KEY = ("id",)
    SHARED = True

    id: Annotated[int, COUNTED, "counts up, and is never used again"]
    table_name: Annotated[str, "the table"]
    row_key: Annotated[tuple[Any, ...], "the row's primary key (after an update, the new one)"]
    operation: Annotated[Literal["insert", "update", "delete"], "the operation"]
    old_row: Annotated[dict[str, Any] | None, "the row before; NULL for an insert"] = None
    new_row: Annotated[dict[str, Any] | None, "the row after; NULL for a delete"] = None
    changed_at: Annotated[str, NOW, "when"]


class EventEntry(Row, frozen=True, kw_only=True):
    """Events, written by lbr. The oldest of very many are deleted."""

    TABLE = "event"
    KEY = ("id",)
    SHARED = True

    id: Annotated[int, COUNTED, "counts up, and is never used again"]
    wall_ns: Annotated[int, Meta(ge=0), "nanoseconds since 1970 by the wall clock"]
    kind: Annotated[str, "started, stopped, crashed, refused, row_changed ..."]
    subject: Annotated[str, "the capability or person"] = ""
    level: Annotated[Literal["info", "warning", "error"], "its importance"] = "info"
    text: Annotated[str, "one sentence"] = ""
    data: Annotated[dict[str, Any], "its figures"] = field(default_factory=dict)


class AdoptedEntry(Row, frozen=True, kw_only=True):
    """The row sets that ran, written by lbr. They show rows that changed without an edit."""

    TABLE = "adopted"
    KEY = ("revision",)
    SHARED = True

    revision: Annotated[int, "its last revision; 0: none"]
    hash: Annotated[str, "BLAKE2b over the rows that make robots"]
    wall_ns: Annotated[int, Meta(ge=0), "its first adoption, nanoseconds since 1970"]


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
