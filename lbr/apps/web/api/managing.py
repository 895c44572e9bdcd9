"""The API's routes for rows, tokens and logs: the executive answers, and this server checks the client's role."""

from typing import Annotated, Literal

from msgspec import Meta, Struct
from starlette.responses import Response

from lbr.apps.web.api.requests import answered, payload_of, replied, source_of
from lbr.apps.web.api.service import Api
from lbr.apps.web.face import Client, get, post
from lbr.messages.manage import (
    MOST_CHANGES,
    MOST_EVENTS,
    ChangeRows,
    LookAtDevices,
    LookAtEvents,
    LookAtLog,
    LookAtRows,
    LookAtTokens,
    ManageReply,
    RenameToken,
    RevokeToken,
    RowChange,
    UndoRows,
)

ANSWER_S = 10.0
WITHIN_S = ANSWER_S + 1.0
STATUSES = {"unknown_name": 404, "busy": 503, "failed": 503}


class ChangesBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Changes of rows, all or none; without `write` they are only tried."""

    changes: Annotated[list[RowChange], Meta(min_length=1, max_length=MOST_CHANGES)]
    write: bool = False


class ManageRefusal(ManageReply, frozen=True, kw_only=True):
    """A refusal: `message` as in every refusal, `code` for programs, and the faulty rows."""

    accepted: bool = False
    message: str


Managed = Annotated[Response, {200: ManageReply, **dict.fromkeys((400, 404, 409, 503), ManageRefusal)}]


class UndoBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A change of rows, by the revision in its answer."""

    revision: Annotated[int, Meta(ge=1)]


class NameBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A token, by its name."""

    name: Annotated[str, Meta(max_length=64)]


class CalledBody(NameBody, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A token, by its name, and its name for people."""

    called: Annotated[str, Meta(min_length=1, max_length=40)]


class EventsWanted(Struct, frozen=True, kw_only=True):
    """The selection of events: the capability or other subject, the least level, and the number."""

    subject: Annotated[str, Meta(max_length=80)] = ""
    level: Literal["info", "warning", "error"] = "info"
    limit: Annotated[int, Meta(ge=1, le=MOST_EVENTS)] = MOST_EVENTS


class Managing:
    """The routes; they run in the capability's loop, which resumes them once a round."""

    def __init__(self, api: Api) -> None:
        self._api = api

    @get("/api/rows", role="operate", within_s=WITHIN_S)
    async def _tables(self, client: Client) -> Managed:
        """The tables of the robot's rows."""
        return await self._ask(client, LookAtRows())

    @get("/api/rows/{table}", role="operate", within_s=WITHIN_S)
    async def _rows(self, client: Client, table: str) -> Managed:
        """A table: its schema, and its rows."""
        return await self._ask(client, LookAtRows(table=table[:64]))

    @post("/api/rows", role="admin", within_s=WITHIN_S)
    async def _change(self, client: Client, body: ChangesBody) -> Managed:
        """Change rows, or try a change.

        A row that differs from its `before` is refused with `changed`, and nothing is written.
        """
        return await self._ask(client, ChangeRows(changes=body.changes, write=body.write, by=source_of(client)))

    @post("/api/rows/undo", role="admin", within_s=WITHIN_S)
    async def _undo(self, client: Client, body: UndoBody) -> Managed:
        """Undo a change of rows by the same client. If others have changed its columns since, it is refused with
        `changed`, and nothing is written."""
        return await self._ask(client, UndoRows(revision=body.revision, by=source_of(client)))

    @post("/api/devices", role="admin", within_s=WITHIN_S)
    async def _devices(self, client: Client) -> Managed:
        """The plugged-in devices, and the changes of rows for them. Each device is identified by a query that moves and
        changes nothing; `POST /api/rows` writes the `changes` of a proposal."""
        return await self._ask(client, LookAtDevices())

    @get("/api/tokens", role="admin", within_s=WITHIN_S)
    async def _tokens(self, client: Client) -> Managed:
        """The tokens, and their roles."""
        return await self._ask(client, LookAtTokens())

    @post("/api/tokens/rename", role="admin", within_s=WITHIN_S)
    async def _rename(self, client: Client, body: CalledBody) -> Managed:
        """Store a token's name for people; the token stays as it is."""
        return await self._ask(client, RenameToken(name=body.name, called=body.called, by=source_of(client)))

    @post("/api/tokens/revoke", role="admin", within_s=WITHIN_S)
    async def _revoke(self, client: Client, body: NameBody) -> Managed:
        """Revoke a token."""
        return await self._ask(client, RevokeToken(name=body.name, by=source_of(client)))

    @get("/api/logs/{name}", role="operate", within_s=WITHIN_S)
    async def _log(self, client: Client, name: str) -> Managed:
        """The end of a capability's log."""
        return await self._ask(client, LookAtLog(name=name[:64]))

    @get("/api/events", within_s=WITHIN_S)
    async def _events(self, client: Client, params: EventsWanted) -> Managed:
        """The recorded events, newest first."""
        return await self._ask(client, LookAtEvents(subject=params.subject, level=params.level, limit=params.limit))

    async def _ask(self, client: Client, command: object) -> Response:
        question = self._api.manage(payload_of(command), source=source_of(client), timeout_s=ANSWER_S)
        return replied(await answered(question, ANSWER_S), STATUSES)
