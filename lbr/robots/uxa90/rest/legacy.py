"""The UXA-90's API as a face of the server: routes in the capability's loop, which pass requests on to `Service`."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import msgspec
from starlette.responses import Response

from lbr.apps.web import face as web
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Query, Refused, Request, Route, declared, get, post, route
from lbr.apps.web.robot import Robot
from lbr.messages.system import Role
from lbr.messages.unreadable import UNREADABLE, keyed_once
from lbr.robots.uxa90.rest import parsing
from lbr.robots.uxa90.rest.answers import MotionsAnswer, MotorAnswer, MultiAnswer, PlayedAnswer
from lbr.robots.uxa90.rest.bodies import MotorParams, MultiBody, MultiParams
from lbr.robots.uxa90.rest.editing import Editor
from lbr.robots.uxa90.rest.jobs import JobReply, JobsReply
from lbr.robots.uxa90.rest.service import Service

HERE = "lbr.robots.uxa90.rest"
REFUSED = Refuses({400: "It makes no sense.", 409: "It is not there, is busy, held by another, or not allowed."})
MOVE_S = 4.0
"""A motion's answer may need three replies: of the joints' release, of the motions, and of the joints again."""
NO_JOB = Refuses({404: "there is no such job"})


class Moving(Route):
    """A route of the first version. Its refusals are a sentence alone, as its clients expect."""

    def refused(self, err: Refused) -> Response:
        """Return the refusal's sentence, with the code in a header."""
        return web.json({"message": err.message}, err.status, **{"Reason-Code": err.code, **err.headers})


class Uxa90Face(web.Face):
    """The API of motors and motions (`Service`, `Editor`), and a page to try it."""

    name = "uxa90"

    def __init__(self, robot: Robot) -> None:
        self._service = Service(robot)
        self._editor = Editor(robot, self._service.motors, self._service.buttons)
        layer, layers = robot.settings.layer, sorted({motor.layer for motor in robot.motors})
        if layers and layer not in layers:
            text = f"no row of the table motor has the layer '{layer}', so the API has no motors; there are "
            robot.ctx.event("no_motors", text + ", ".join(layers), level="warning")

    def routes(self) -> Sequence[Route]:
        """Return its routes."""
        return [*declared(self), *declared(self._editor)]

    @get("/", role=None, page=True)
    def _alive(self) -> Annotated[Response, web.TEXT]:
        """Report that the server is alive."""
        return web.text("OK")

    @get("/motor", Moving, within_s=MOVE_S)
    async def _motor(self, request: Request, query: Annotated[Query, MotorParams]) -> Annotated[MotorAnswer, REFUSED]:
        """List motors, read one, or move one.

        Without `id`: all. With `id`: that one. With `pos` as well: it moves (role operate).
        """
        asked = _by_name(query)

        def require(role: Role) -> None:
            _refuse_head(request)
            request.require(role)

        measured = parsing.flag(asked, "measured") if "id" in asked or "measured" in asked else False
        return await self._service.motor(asked, require, measured=measured, came_s=request.came_s)

    @get("/multimotor", Moving, role="operate", within_s=MOVE_S)
    @post("/multimotor", Moving, role="operate", within_s=MOVE_S)
    async def _several(
        self, request: Request, query: Annotated[Query, MultiParams], body: Annotated[bytes, MultiBody]
    ) -> Annotated[MultiAnswer, REFUSED]:
        """Move several motors at once, or each after its delay.

        The whole list is checked first: if anything is wrong with it, nothing moves.
        """
        _refuse_head(request)
        return await self._service.several(_json(request, body), _by_name(query), request.came_s)

    @get("/motion")
    async def _motions(self) -> MotionsAnswer:
        """List motions."""
        return MotionsAnswer(self._service.buttons.all())

    @get("/motion/{key}", Moving, role="operate", within_s=MOVE_S)
    @post("/motion/{key}", Moving, role="operate", within_s=MOVE_S)
    async def _play(self, request: Request, key: str) -> Annotated[PlayedAnswer, REFUSED]:
        """Play a motion, by number or name.

        It plays by itself after the answer; one at a time. 99, pc_control, only takes control of the main board.
        """
        _refuse_head(request)
        return await self._service.play(key, request.came_s)

    @get("/jobs")
    async def _jobs(self) -> JobsReply:
        """List jobs."""
        return JobsReply(self._service.jobs.all())

    @get("/jobs/{job}")
    async def _job(self, job: str) -> Annotated[JobReply, NO_JOB]:
        """Read a job."""
        return JobReply(self._service.jobs.get(job))

    @route("DELETE", "/jobs/{job}", role="operate")
    async def _cancel(self, job: str) -> Annotated[JobReply, NO_JOB, Refuses({409: "it is over"})]:
        """Cancel a job: its remaining steps do not begin."""
        return JobReply(self._service.jobs.cancel(job))

    @get("/demo", role=None, page=True)
    def _demo(self) -> Annotated[Response, web.HTML]:
        """A page to move the head and to play motions."""
        return web.static(HERE, "demo.html")

    @get("/demo.js", role=None, page=True)
    def _demo_js(self) -> Response:
        return web.static(HERE, "demo.js", web.SCRIPT)

    @get("/demo.css", role=None, page=True)
    def _demo_css(self) -> Response:
        return web.static(HERE, "demo.css", web.STYLE)

    def step(self, now: float) -> None:
        """Renew leases, and begin due moves."""
        self._service.step(now)

    def stopped(self, reason: str) -> None:
        """Drop everything that waits."""
        self._service.stopped(reason)

    def state(self) -> Mapping[str, Any]:
        """Return the commanded positions of motors, the current motion, and the number of waiting jobs."""
        return self._service.state()

    @property
    def jobs(self) -> int:
        """Return the number of waiting jobs."""
        return self._service.jobs.waiting


def _refuse_head(request: Request) -> None:
    """Refuse to move for a client that only requests headers."""
    if request.method == "HEAD":
        raise Refused(405, "HEAD moves nothing: use GET or POST", {"Allow": "GET, POST"})


def _by_name(query: Query) -> parsing.Query:
    values: dict[str, list[str]] = {}
    for name, value in query:
        values.setdefault(name, []).append(value)
    return values


def _json(request: Request, body: bytes) -> object:
    """Return the content of a JSON body; refuse a missing one, another media type, and invalid JSON."""
    media = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if not body:
        raise Refused(400, f"a body is needed: {parsing.EXAMPLE}, as application/json")
    if media != web.JSON:
        raise Refused(400, f"the body must be application/json, not '{media[:60]}'")
    try:
        return msgspec.json.decode(keyed_once(body))
    except UNREADABLE as err:
        raise Refused(400, f"the body is not JSON: {err}") from None
