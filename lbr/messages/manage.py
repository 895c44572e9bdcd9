"""Messages of pages for people: to look at a robot's rows, tokens and logs, and to change rows. Values are JSON."""

from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode

MOST_CHANGES = 256
LOG_BYTES = 64_000
MOST_EVENTS = 200
TableName = Annotated[str, Meta(max_length=64)]
Asker = Annotated[str, Meta(max_length=80, description="who asks, for events and the audit trail")]


class RowChange(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One row: `before` as it was read, null for a new row; `after` as it shall be, null to delete it.

    A column that `after` leaves out stays as it is, or has its default.
    """

    table: TableName
    before: dict[str, Any] | None = None
    after: dict[str, Any] | None = None


class LookAtRows(Struct, frozen=True, kw_only=True, tag_field="ask", tag="rows"):
    """List the tables, or one of them with its rows and their schema."""

    table: TableName = ""


class ChangeRows(Struct, frozen=True, kw_only=True, tag_field="ask", tag="change"):
    """Change rows, all or none; without `write`, only report the effects."""

    changes: Annotated[list[RowChange], Meta(min_length=1, max_length=MOST_CHANGES)]
    write: bool = False
    by: Asker = ""


class UndoRows(Struct, frozen=True, kw_only=True, tag_field="ask", tag="undo"):
    """Undo a change of rows: the one of the same sender that ended with this revision."""

    revision: Annotated[int, Meta(ge=1)]
    by: Asker = ""


class LookAtTokens(Struct, frozen=True, kw_only=True, tag_field="ask", tag="tokens"):
    """List the tokens, without their secrets."""


class RevokeToken(Struct, frozen=True, kw_only=True, tag_field="ask", tag="revoke"):
    """Revoke a token."""

    name: Annotated[str, Meta(max_length=64)]
    by: Asker = ""


class RenameToken(Struct, frozen=True, kw_only=True, tag_field="ask", tag="rename"):
    """Store a token's name for people."""

    name: Annotated[str, Meta(max_length=64)]
    called: Annotated[str, Meta(min_length=1, max_length=40)]
    by: Asker = ""


class LookAtLog(Struct, frozen=True, kw_only=True, tag_field="ask", tag="log"):
    """Return the end of a capability's log."""

    name: Annotated[str, Meta(max_length=64)]


class LookAtEvents(Struct, frozen=True, kw_only=True, tag_field="ask", tag="events"):
    """Return the newest stored events, the newest first; optionally of one capability, or from a level on."""

    subject: Annotated[str, Meta(max_length=80)] = ""
    level: Literal["info", "warning", "error"] = "info"
    limit: Annotated[int, Meta(ge=1, le=MOST_EVENTS)] = MOST_EVENTS


class LookAtDevices(Struct, frozen=True, kw_only=True, tag_field="ask", tag="devices"):
    """Find the plugged-in devices, identify each, and return the changes of rows with which the robot uses it."""


ManageCommand = (
    LookAtDevices
    | LookAtRows
    | ChangeRows
    | UndoRows
    | LookAtTokens
    | RenameToken
    | RevokeToken
    | LookAtLog
    | LookAtEvents
)


class RowProblem(Struct, frozen=True, kw_only=True):
    """A problem of a row; `column` may be empty for the whole row."""

    table: str
    row: str
    column: str
    text: str


class Touched(Struct, frozen=True, kw_only=True):
    """The processes that a change of rows starts, stops or restarts, or that receive more devices."""

    start: tuple[str, ...] = ()
    stop: tuple[str, ...] = ()
    restart: tuple[str, ...] = ()
    plug: tuple[str, ...] = ()


class ManageReply(Struct, frozen=True, kw_only=True):
    """The result: `data` is the requested content, `touched` the effect of a change; `problems` prevent it.

    For a row that was changed meanwhile, `changed_by` is the author, empty for a program that edits the database, and
    `changed_at` the time.
    """

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    revision: int = 0
    problems: tuple[RowProblem, ...] = ()
    touched: Touched | None = None
    changed_by: str = ""
    changed_at: str = ""
    data: Any = None
