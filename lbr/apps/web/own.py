"""What the server answers whatever its faces are: states, stopping, where it is, and what there is to ask."""

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from html import escape
from importlib import resources
from typing import Annotated, Any

from msgspec import Meta, Struct

from lbr.apps.web import openapi, qr
from lbr.apps.web.face import HTML, SVG, Ask, Face, Message, Refused, Reply, Route, html, json, text
from lbr.apps.web.place import Place
from lbr.apps.web.robot import Robot
from lbr.apps.web.states import State, States
from lbr.messages.leases import StopCommand
from lbr.messages.system import EstopResetCommand

STOPS = ("halt", "stop_motion")
NOTICED_S = 0.5
LOOK_S = 0.01
RESET_S = 3.0
PAGE = "text/css", "text/javascript"


class EstopBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Why the emergency stop is engaged."""

    reason: Annotated[str, Meta(max_length=200)] = ""


class EstopAnswer(Struct, frozen=True, kw_only=True):
    """`noticed`: the joints have said that they heard of it."""

    message: str
    engaged: bool
    noticed: bool


class Own:
    """The server's own routes."""

    def __init__(self, robot: Robot, states: States, place: Place, faces: Sequence[Face]) -> None:
        self._robot = robot
        self._states = states
        self._place = place
        self._faces = faces
        self._document = b""

    def routes(self) -> list[Route]:
        """Return them."""
        moves: dict[str, Any] = {"replies": {200: Message}, "role": "view"}
        page: dict[str, Any] = {"role": None, "page": True, "hidden": True}
        return [
            Route(
                method="GET", path="/state", handle=self._state, summary="The newest state of everything that moves",
                description="The WebSocket `/ws?rate_hz=20` sends the same whenever it changes.", replies={200: State},
            ),
            Route(
                method="POST", path="/stop", handle=self._stop, summary="Stop, and hold where the joints are",
                regardless=True, refuses={409: "The robot does not stop so."}, **moves,
            ),
            Route(
                method="POST", path="/estop", handle=self._estop, summary="Latch the emergency stop",
                description="Whatever the body is: one that is no JSON only gives no reason.",
                replies={200: EstopAnswer}, body=EstopBody, body_required=False, regardless=True,
            ),
            Route(
                method="POST", path="/estop/reset", handle=self._reset, summary="Release the emergency stop",
                description="By itself this moves nothing.", replies={200: Message}, role="operate",
                refuses={409: "It stays latched."},
            ),
            Route(
                method="GET", path="/openapi.json", handle=self._openapi, summary="This document",
                replies={200: dict[str, Any]}, role=None, page=True,
            ),
            Route(
                method="GET", path="/qr.svg", handle=self._qr_svg, summary="The server's address as a QR code",
                replies={200: SVG}, role=None, page=True, refuses={404: "Only this machine reaches it."},
            ),
            Route(
                method="GET", path="/qr", handle=self._qr, summary="The same on a page", replies={200: HTML},
                role=None, page=True,
            ),
            Route(method="GET", path="/docs", handle=_static("docs.html", HTML), summary="", replies={200: HTML}, **page),
            Route(
                method="GET", path="/docs.js", handle=_static("docs.js", PAGE[1]), summary="", replies={200: PAGE[1]},
                **page,
            ),
            Route(
                method="GET", path="/docs.css", handle=_static("docs.css", PAGE[0]), summary="", replies={200: PAGE[0]},
                **page,
            ),
        ]  # fmt: skip

    def describe(self, routes: Sequence[Route], version: str) -> None:
        """Make the document of all routes there are."""
        self._document = json(
            openapi.document(
                routes,
                title=f"The robot {self._robot.name}",
                description='What this robot answers over HTTP. A refusal is {"message": "the reason"}.',
                version=version,
            )
        ).body

    async def _state(self, _ask: Ask) -> Reply:
        return Reply(body=self._states.encoded(self._robot.snapshot))

    async def _stop(self, ask: Ask) -> Reply:
        why = f"stopped by {ask.client}"
        await self._robot.call(lambda: self._forget(why))
        wired = [request for request in STOPS if self._robot.ctx.targets(request)]
        if not wired:
            raise Refused(503, "nothing that could be stopped is wired to this server by channel rows")
        answers = await asyncio.gather(
            *(self._robot.ask(request, StopCommand(reason=why[:200], whole=True)) for request in wired),
            return_exceptions=True,
        )
        if wired[0] == STOPS[0] and getattr(answers[0], "accepted", False):
            return json(Message(message="stopped"))  # the joints stand; who moved them may be starting anew
        for answer in answers:
            if isinstance(answer, BaseException):
                raise answer
            if not answer.accepted:
                raise Refused(409, answer.reason or "it was refused without a reason")
        return json(Message(message="stopped"))

    async def _estop(self, ask: Ask) -> Reply:
        given = ask.data.reason if ask.data is not None else ""
        why = f"{given} ({ask.client})" if given else f"by {ask.client}"
        await self._robot.call(lambda: self._engage(why))
        loop = asyncio.get_running_loop()
        end = loop.time() + NOTICED_S
        while not (noticed := self._is_latched()) and loop.time() < end:  # noqa: ASYNC110 - states come by themselves
            await asyncio.sleep(LOOK_S)
        return json(EstopAnswer(message="the emergency stop is engaged", engaged=True, noticed=noticed))

    async def _reset(self, _ask: Ask) -> Reply:
        reply = await self._robot.ask("estop_reset", EstopResetCommand(), timeout_s=RESET_S)
        if not reply.accepted:
            raise Refused(409, reply.reason or "it was refused without a reason")
        return json(Message(message=reply.reason or "released"))

    async def _openapi(self, _ask: Ask) -> Reply:
        return Reply(body=self._document)

    async def _qr_svg(self, _ask: Ask) -> Reply:
        if not self._place.open or not self._place.url:
            raise Refused(404, self._place.words())
        return Reply(body=qr.drawing(self._place.url), media=SVG)

    async def _qr(self, _ask: Ask) -> Reply:
        lines = "".join(f"<p>{escape(line)}</p>" for line in self._place.words().splitlines())
        picture = '<img src="/qr.svg" alt="the address as a QR code">' if self._place.open and self._place.url else ""
        head = '<meta name="viewport" content="width=device-width"><link rel="stylesheet" href="/docs.css">'
        title = f"<title>{escape(self._robot.name)}</title>"
        return html(f'<!DOCTYPE html><html lang="en">{head}{title}<body class="qr">{picture}{lines}</body></html>')

    def _is_latched(self) -> bool:
        joints = self._robot.snapshot.joints_state
        return joints is not None and joints.estop

    def _forget(self, why: str) -> None:
        for face in self._faces:
            face.stopped(why)

    def _engage(self, why: str) -> None:
        self._robot.ctx.engage_estop(why)
        self._forget(f"emergency stop: {why}")


def _static(name: str, media: str) -> Callable[[Ask], Awaitable[Reply]]:
    content = (resources.files("lbr.apps.web") / "pages" / name).read_text(encoding="utf-8")

    async def answer(_ask: Ask) -> Reply:
        return text(content, media=media)

    return answer
