"""The API's routes for rows, tokens and logs: asked of the executive, with the role of who asks looked at here."""

from typing import Annotated, Any, Literal, Protocol

from msgspec import Meta, Struct
from starlette.responses import Response

from lbr.apps.web.api.requests import answered, payload_of, replied, source_of
from lbr.apps.web.api.robot_bus import Question
from lbr.apps.web.face import Request, Route
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
    RevokeToken,
    RowChange,
)

ANSWER_S = 10.0
STATUSES = {"unknown_name": 404, "busy": 503, "failed": 503}


class ChangesBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Changes of rows, all or none; without `write` the answer only tells what they would do."""

    changes: Annotated[list[RowChange], Meta(min_length=1, max_length=MOST_CHANGES)]
    write: bool = False


class ManageRefusal(ManageReply, frozen=True, kw_only=True):
    """Why not: `message` as in every refusal, `code` for programs, and what is wrong with which row."""

    accepted: bool = False
    message: str


class NameBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A token, by its name."""

    name: Annotated[str, Meta(max_length=64)]


class EventsWanted(Struct, frozen=True, kw_only=True):
    """Which events: of one capability or other subject, from a level on, and how many."""

    subject: Annotated[str, Meta(max_length=80)] = ""
    level: Literal["info", "warning", "error"] = "info"
    limit: Annotated[int, Meta(ge=1, le=MOST_EVENTS)] = MOST_EVENTS


class Asks(Protocol):
    """What the routes need: in the capability's loop."""

    def manage(self, payload: bytes, *, source: str, timeout_s: float) -> Question:
        """Ask the executive; Refused (503) without a bus."""


class Managing:
    """The routes; they run in the capability's loop, where they are resumed once a round."""

    def __init__(self, robot: Asks) -> None:
        self._robot = robot

    def routes(self) -> list[Route]:
        """Return what is answered."""
        answered = {200: ManageReply, **dict.fromkeys((400, 404, 409, 503), ManageRefusal)}
        return [
            Route(
                method="GET", path="/api/rows", handle=self._tables, summary="The tables of rows that the robot is made of",
                replies=answered, role="operate", within_s=ANSWER_S + 1.0,
            ),
            Route(
                method="GET", path="/api/rows/{table}", handle=self._rows, summary="A table: its schema, and its rows",
                replies=answered, role="operate", within_s=ANSWER_S + 1.0,
            ),
            Route(
                method="POST", path="/api/rows", handle=self._change, summary="Change rows, or try what that would do",
                description="A row that is not any more as `before` says is refused with `changed`, and nothing is written.",
                replies=answered, body=ChangesBody, role="admin", within_s=ANSWER_S + 1.0,
            ),
            Route(
                method="POST", path="/api/devices", handle=self._devices, summary="What is plugged in, and the changes of rows it is worth",
                description="Each is asked by a question that moves and changes nothing; `POST /api/rows` writes the `changes` of a proposal.",
                replies=answered, role="admin", within_s=ANSWER_S + 1.0,
            ),
            Route(
                method="GET", path="/api/tokens", handle=self._tokens, summary="Who may come in by a token",
                replies=answered, role="admin", within_s=ANSWER_S + 1.0,
            ),
            Route(
                method="POST", path="/api/tokens/revoke", handle=self._revoke, summary="Lock a token out",
                replies=answered, body=NameBody, role="admin", within_s=ANSWER_S + 1.0,
            ),
            Route(
                method="GET", path="/api/logs/{name}", handle=self._log, summary="The end of what a capability has written to its log",
                replies=answered, role="operate", within_s=ANSWER_S + 1.0,
            ),
            Route(
                method="GET", path="/api/events", handle=self._events, summary="What happened, the newest first, as it was written down",
                replies=answered, params=EventsWanted, role="view", within_s=ANSWER_S + 1.0,
            ),
        ]  # fmt: skip

    async def _tables(self, request: Request) -> Response:
        return await self._ask(request, LookAtRows())

    async def _rows(self, request: Request) -> Response:
        return await self._ask(request, LookAtRows(table=request.keys["table"][:64]))

    async def _change(self, request: Request) -> Response:
        body: ChangesBody = request.data
        command = ChangeRows(changes=body.changes, write=body.write, by=source_of(request.client))
        return await self._ask(request, command)

    async def _devices(self, request: Request) -> Response:
        return await self._ask(request, LookAtDevices())

    async def _tokens(self, request: Request) -> Response:
        return await self._ask(request, LookAtTokens())

    async def _revoke(self, request: Request) -> Response:
        return await self._ask(request, RevokeToken(name=request.data.name, by=source_of(request.client)))

    async def _log(self, request: Request) -> Response:
        return await self._ask(request, LookAtLog(name=request.keys["name"][:64]))

    async def _events(self, request: Request) -> Response:
        wanted: EventsWanted = request.params
        return await self._ask(request, LookAtEvents(subject=wanted.subject, level=wanted.level, limit=wanted.limit))

    async def _ask(self, request: Request, command: Any) -> Response:
        source = source_of(request.client)
        question = self._robot.manage(payload_of(command), source=source, timeout_s=ANSWER_S)
        return replied(await answered(question, ANSWER_S), STATUSES)
