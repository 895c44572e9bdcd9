"""The server's own routes, without any face: states, stops, its address, and its documentation."""

from collections.abc import Sequence
from contextlib import suppress
from html import escape
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct
from starlette.responses import Response

from lbr import qr
from lbr.apps.web import openapi
from lbr.apps.web.advertised_address import AdvertisedAddress
from lbr.apps.web.api.documented import with_robot
from lbr.apps.web.api.requests import source_of
from lbr.apps.web.api.service import Api
from lbr.apps.web.bridge import until
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import (
    HTML,
    SCRIPT,
    STYLE,
    SVG,
    Message,
    Refused,
    Request,
    Route,
    encoded,
    get,
    post,
    static,
    text,
)
from lbr.apps.web.faces import Faces
from lbr.apps.web.robot import Robot
from lbr.apps.web.states import State, States
from lbr.bus.codec import Decoder
from lbr.bus.wire import PendingQuery
from lbr.capability.kind import STOP
from lbr.errors import MalformedError
from lbr.leases.client import PendingReply
from lbr.messages.codes import heard
from lbr.messages.description import Schema
from lbr.messages.leases import StopCommand
from lbr.messages.system import ConsoleResult, EstopResetCommand

STOPS = ("halt", "stop_motion")
"""The request ports for stops, first those of capabilities that move by themselves: once they stand, the robot does."""
NOTICED_S = 0.5
RESET_S, STOP_S, LINE_S = 3.0, 1.0, 3.0
AWAY = 503
"""The status of a stop that was not answered."""
HERE = "lbr.apps.web"
_results = Decoder(ConsoleResult)


class EstopBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The reason for the emergency stop."""

    reason: Annotated[str, Meta(max_length=200)] = ""


class EstopAnswer(Struct, frozen=True, kw_only=True):
    """The result; `noticed`: joints and wheels, as far as the robot has them, report the stop."""

    message: str
    engaged: bool
    noticed: bool


class BuiltinRoutes:
    """The server's own routes."""

    def __init__(self, robot: Robot, states: States, place: AdvertisedAddress, faces: Faces, api: Api) -> None:
        self._api = api
        self._robot = robot
        self._states = states
        self._place = place
        self._faces = faces
        self._document: Schema = {}
        self._encoded: tuple[object, bytes] = (self, b"")
        self._begun = self._ended = 0
        self._refused: Refused | None = None

    @get("/docs", role=None, page=True)
    def _docs(self) -> Response:
        return static(HERE, "docs.html")

    @get("/docs.js", role=None, page=True)
    def _docs_js(self) -> Response:
        return static(HERE, "docs.js", SCRIPT)

    @get("/docs.css", role=None, page=True)
    def _docs_css(self) -> Response:
        return static(HERE, "docs.css", STYLE)

    def describe(self, routes: Sequence[Route], version: str) -> None:
        """Make the document of all routes."""
        self._document = openapi.document(
            routes,
            title=f"The robot {self._robot.name}",
            description='What this robot answers by HTTP. A refusal is {"message": "its reason", "code": "its_code"}.',
            version=version,
        )

    @get("/state")
    def _state(self) -> Annotated[Response, {200: State}]:
        """The newest state of everything that moves.

        The WebSocket `/ws?rate_hz=20` sends the same after each change.
        """
        return encoded(self._states.encoded(self._robot.snapshot))

    @post("/stop", stops=True, within_s=2 * (STOP_S + LINE_S))
    async def _stop(self, request: Request) -> Annotated[Message, Refuses({409: "The robot does not stop so."})]:
        """Stop: wheels stand, joints hold where they are."""
        # Requests during a round share the next one, so that each capability is asked at most once a round.
        why = f"stopped by {request.client}"
        self._api.stopped(request.came_s)
        self._faces.stopped(why)
        wanted = self._begun + 1
        await until(lambda: self._ended >= wanted or self._ended == self._begun)
        if self._ended < wanted:
            self._begun += 1
            try:
                self._refused = await self._stop_all(why, source_of(request.client))
            finally:
                self._ended = self._begun
        if self._refused is not None:
            raise self._refused
        return Message(message="stopped")

    async def _stop_all(self, why: str, source: str) -> Refused | None:
        """Ask all wired capabilities to stop; return why one does not.

        A capability that moves by itself answers once it stands. If one whose motion can be held here is not wired, the
        console's stop is sent as well, which no row disables. The same if one does not answer, as it may be restarting.
        """
        stop = StopCommand(reason=why[:200], whole=True)
        asked = {name: self._robot.ctx.ask(name, stop, STOP_S) for name in self._wired()}
        wired = {target for name in asked for target in self._robot.ctx.targets(name)}
        line = self._say_stop(source) if not self._lenders() <= wired else None
        if not asked and line is None:
            return Refused(503, "nothing that could be stopped is wired to this server by channel rows", code="wiring")
        refused = None
        for request, question in asked.items():
            refused = await _refusal(question)
            if refused is not None or request == STOPS[0]:
                break  # all that moves stands; the capability that moved it may be restarting
        if refused is not None and refused.status == AWAY and line is None:
            line = self._say_stop(source)
        if refused is not None and (refused.status != AWAY or line is None):
            return refused
        if line is None:
            return None
        await until(lambda: line.done or bool(line.replies))
        return _unless_done(line)

    def _lenders(self) -> frozenset[str]:
        return self._api.known.lenders if self._api.known is not None else frozenset()

    def _say_stop(self, source: str) -> PendingQuery | None:
        with suppress(Refused):  # there is no bus
            return self._api.line(STOP, role="view", source=source, timeout_s=LINE_S)
        return None

    def _wired(self) -> list[str]:
        return [request for request in STOPS if self._robot.ctx.targets(request)]

    @post("/estop", stops=True)
    async def _estop(self, request: Request, body: EstopBody | None = None) -> EstopAnswer:
        """Latch the emergency stop.

        Any body is accepted; one that is not JSON gives no reason.
        """
        given = body.reason if body is not None else ""
        why = f"{given} ({request.client})" if given else f"by {request.client}"
        self._api.stopped(request.came_s)
        self._robot.ctx.engage_estop(why)
        self._faces.stopped(f"emergency stop: {why}")
        end = self._robot.now() + NOTICED_S
        await until(lambda: self._is_latched() or self._robot.now() >= end)
        state, noticed = self._api.estop, self._robot.snapshot.is_latched
        message = (state.text if state is not None else "") or "the emergency stop is engaged"
        return EstopAnswer(message=message, engaged=True, noticed=noticed)

    def _is_latched(self) -> bool:
        state = self._api.estop
        return self._robot.snapshot.is_latched and (state is None or state.engaged)

    @post("/estop/reset", role="operate")
    async def _reset(self) -> Annotated[Message, Refuses({409: "It stays latched."})]:
        """Release the emergency stop.

        This alone moves nothing.
        """
        reply = await self._robot.ask("estop_reset", EstopResetCommand(), timeout_s=RESET_S)
        if not reply.accepted:
            raise Refused(409, reply.why)
        return Message(message=reply.reason or "released")

    @get("/openapi.json", role=None, page=True)
    def _openapi(self) -> Annotated[Response, {200: dict[str, Any]}]:
        """This document."""
        known = self._api.known
        if self._encoded[0] is not known:
            whole = with_robot(self._document, known) if known is not None else self._document
            self._encoded = known, msgspec.json.encode(whole)
        return encoded(self._encoded[1])

    @get("/qr.svg", role=None, page=True)
    def _qr_svg(self) -> Annotated[Response, SVG, Refuses({404: "Only this machine reaches it."})]:
        """The server's address as a QR code."""
        if not self._place.open or not self._place.url:
            raise Refused(404, self._place.words())
        return Response(qr.drawing(self._place.url), media_type=SVG)

    @get("/qr", role=None, page=True)
    def _qr(self) -> Annotated[Response, HTML]:
        """The same on a page."""
        lines = "".join(f"<p>{escape(line)}</p>" for line in self._place.words().splitlines())
        picture = '<img src="/qr.svg" alt="the address as a QR code">' if self._place.open and self._place.url else ""
        head = '<meta name="viewport" content="width=device-width"><link rel="stylesheet" href="/docs.css">'
        title = f"<title>{escape(self._robot.name)}</title>"
        return text(
            f'<!DOCTYPE html><html lang="en">{head}{title}<body class="qr">{picture}{lines}</body></html>', media=HTML
        )


async def _refusal(asked: PendingReply) -> Refused | None:
    """Return why a capability does not stop, a refusal before a silence; None if all do."""
    await until(lambda: asked.answers() is not None)
    answers = (asked.answers() or {}).items()
    away = [name for name, one in answers if one is None or one.code == "shutting_down"]
    said_no = [Refused(409, one.why) for name, one in answers if one and not one.accepted and name not in away]
    silent = [Refused(AWAY, f"'{name}' does not answer", {"Retry-After": "1"}) for name in away]
    return next(iter(said_no + silent), None)


def _unless_done(question: PendingQuery) -> Refused | None:
    """Return why a console line failed; None if it succeeded."""
    if not question.replies:
        return Refused(AWAY, "the robot does not answer", {"Retry-After": "1"})
    try:
        result = _results.decode(question.replies[0].payload)
    except MalformedError as err:
        return Refused(503, str(err), code="malformed")
    status = AWAY if result.reason_code == "unreachable" else 409
    return None if result.code == 0 else Refused(status, heard(result.reason_code or "refused", result.text))
