"""Messages by which people look at a robot's rows, tokens and logs, and change rows, from a page. Values are as JSON
has them."""

from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode

MOST_CHANGES = 256
LOG_BYTES = 64_000
MOST_EVENTS = 200
TableName = Annotated[str, Meta(max_length=64)]
Asker = Annotated[str, Meta(max_length=80, description="who asks, for events and the audit trail")]


class RowChange(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One row: `before` as it was when it was looked at, null for a new one; `after` as it is to be, null to delete it.

    A column that `after` leaves out stays as it is, or has its default.
    """

    table: TableName
    before: dict[str, Any] | None = None
    after: dict[str, Any] | None = None


class LookAtRows(Struct, frozen=True, kw_only=True, tag_field="ask", tag="rows"):
    """Tell which tables there are, or one of them with its rows and their schema."""

    table: TableName = ""


class ChangeRows(Struct, frozen=True, kw_only=True, tag_field="ask", tag="change"):
    """Change rows, all or none; without `write` only tell what that would do."""

    changes: Annotated[list[RowChange], Meta(min_length=1, max_length=MOST_CHANGES)]
    write: bool = False
    by: Asker = ""


class UndoRows(Struct, frozen=True, kw_only=True, tag_field="ask", tag="undo"):
    """Take a change of rows back: the one of the same asker that ended with this revision."""

    revision: Annotated[int, Meta(ge=1)]
    by: Asker = ""


class LookAtTokens(Struct, frozen=True, kw_only=True, tag_field="ask", tag="tokens"):
    """Tell which tokens there are, without what proves them."""


class RevokeToken(Struct, frozen=True, kw_only=True, tag_field="ask", tag="revoke"):
    """Take a token's rights away."""

    name: Annotated[str, Meta(max_length=64)]
    by: Asker = ""


class LookAtLog(Struct, frozen=True, kw_only=True, tag_field="ask", tag="log"):
    """Tell the end of what a capability has written to its log."""

    name: Annotated[str, Meta(max_length=64)]


class LookAtEvents(Struct, frozen=True, kw_only=True, tag_field="ask", tag="events"):
    """Tell the newest events that were written down, the newest first: of one capability, or from a level on, if so
    asked."""

    subject: Annotated[str, Meta(max_length=80)] = ""
    level: Literal["info", "warning", "error"] = "info"
    limit: Annotated[int, Meta(ge=1, le=MOST_EVENTS)] = MOST_EVENTS


class LookAtDevices(Struct, frozen=True, kw_only=True, tag_field="ask", tag="devices"):
    """Look at what is plugged in, ask each what it is, and tell the changes of rows that would have the robot use
    it."""


ManageCommand = (
    LookAtDevices | LookAtRows | ChangeRows | UndoRows | LookAtTokens | RevokeToken | LookAtLog | LookAtEvents
)


class RowProblem(Struct, frozen=True, kw_only=True):
    """A problem of a row; `column` may be empty for the whole row."""

    table: str
    row: str
    column: str
    text: str


class Touched(Struct, frozen=True, kw_only=True):
    """The processes that a change of rows starts, stops, restarts, or tells of more devices."""

    start: tuple[str, ...] = ()
    stop: tuple[str, ...] = ()
    restart: tuple[str, ...] = ()
    plug: tuple[str, ...] = ()


class ManageReply(Struct, frozen=True, kw_only=True):
    """The result: `data` is what was looked at, `touched` the effect of a change; `problems` are in its way.

    Of a row that was changed meanwhile, `changed_by` says who did it, empty for a program that edits the database, and
    `changed_at` when.
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
