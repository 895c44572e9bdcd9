"""What answers each route, in the capability's loop: from a request to `Service` and rows, and back to an answer."""

from typing import Any

import msgspec
from starlette.responses import Response

from lbr.apps.web import face as web
from lbr.apps.web.face import Request
from lbr.apps.web.robot import Robot
from lbr.messages.system import Role
from lbr.messages.unreadable import UNREADABLE, keyed_once
from lbr.robots.uxa90.rest import parsing
from lbr.robots.uxa90.rest.answers import MotionsAnswer
from lbr.robots.uxa90.rest.bodies import MotionRowAnswer, MotorRowAnswer
from lbr.robots.uxa90.rest.editing import Editor
from lbr.robots.uxa90.rest.jobs import JobReply, JobsReply
from lbr.robots.uxa90.rest.service import Service


class Handlers:
    """What may be asked; plain functions are answered at once, from what does not change."""

    def __init__(self, robot: Robot, work: Service) -> None:
        self._work = work
        self._editor = Editor(robot, work.motors, work.buttons)

    async def motor(self, request: Request) -> Response:
        """List, show or move."""
        query = _query(request)

        def require(role: Role) -> None:
            _refuse_head(request)
            request.require(role)

        wanted = parsing.flag(query, "measured") if "id" in query or "measured" in query else False
        return web.json(await self._work.motor(query, require, measured=wanted, came_s=request.came_s))

    async def several(self, request: Request) -> Response:
        """Move several."""
        _refuse_head(request)
        return web.json(await self._work.several(_body(request), _query(request), request.came_s))

    async def motions(self, _request: Request) -> Response:
        """List them."""
        return web.json(MotionsAnswer(self._work.buttons.all()))

    async def play(self, request: Request) -> Response:
        """Play one."""
        _refuse_head(request)
        return web.json(await self._work.play(request.keys["key"], request.came_s))

    async def jobs(self, _request: Request) -> Response:
        """List them."""
        return web.json(JobsReply(self._work.jobs.all()))

    async def job(self, request: Request) -> Response:
        """Show one."""
        return web.json(JobReply(self._work.jobs.get(request.keys["job"])))

    async def cancel(self, request: Request) -> Response:
        """Cancel one."""
        return web.json(JobReply(self._work.jobs.cancel(request.keys["job"])))

    async def show_motor(self, request: Request) -> Response:
        """Show a row."""
        return _row(await self._editor.show_motor(request.keys["id"]))

    async def show_motion(self, request: Request) -> Response:
        """Show a row."""
        return _row(await self._editor.show_motion(request.keys["id"]))

    async def add_motor(self, request: Request) -> Response:
        """Make a row."""
        return _row(await self._editor.add_motor(request, request.data), 201)

    async def change_motor(self, request: Request) -> Response:
        """Change a row."""
        return _row(await self._editor.change_motor(request, request.keys["id"], request.data))

    async def add_motion(self, request: Request) -> Response:
        """Make a row."""
        return _row(await self._editor.add_motion(request, request.data), 201)

    async def change_motion(self, request: Request) -> Response:
        """Change a row."""
        return _row(await self._editor.change_motion(request, request.keys["id"], request.data))


def ok(_request: Request) -> Response:
    """Say that it is there."""
    return web.text("OK")


def _refuse_head(request: Request) -> None:
    """Move nothing for a client that only asks what there is."""
    if request.method == "HEAD":
        raise web.Refused(405, "HEAD moves nothing: use GET or POST", {"Allow": "GET, POST"})


def _row(answer: MotorRowAnswer | MotionRowAnswer, status: int = 200) -> Response:
    return web.json(answer, status, ETag=f'"{answer.version}"')


def _query(request: Request) -> parsing.Query:
    found: dict[str, list[str]] = {}
    for name, value in request.query:
        found.setdefault(name, []).append(value)
    return found


def _body(request: Request) -> Any:
    """Return what a body says, whatever that is; refuse none, other kinds of it, and what is not JSON."""
    media = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if not request.body:
        raise web.Refused(400, f"a body is needed: {parsing.EXAMPLE}, as application/json")
    if media != web.JSON:
        raise web.Refused(400, f"the body must be application/json, not '{media[:60]}'")
    try:
        return msgspec.json.decode(keyed_once(request.body))
    except UNREADABLE as err:
        raise web.Refused(400, f"the body is not JSON: {err}") from None
