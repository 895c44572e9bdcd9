"""What answers each route, on the server's thread: it reads the request, and has the capability's loop do the rest."""

from collections.abc import Callable
from typing import Any

import msgspec

from lbr.apps.web import face as web
from lbr.apps.web.bridge import Promise
from lbr.apps.web.face import Ask, Reply
from lbr.apps.web.robot import Robot
from lbr.apps.web.uxa90 import deciding
from lbr.apps.web.uxa90.answers import MotionsAnswer, MotorAnswer, MultiAnswer, PlayedAnswer
from lbr.apps.web.uxa90.bodies import MotionRowAnswer, MotorRowAnswer
from lbr.apps.web.uxa90.editing import Editor
from lbr.apps.web.uxa90.jobs import JobReply, JobsReply
from lbr.apps.web.uxa90.work import Work
from lbr.messages.system import Role

ANSWER_S = 4.0
"""A motion's answer may need three others': the joints given back, motions, joints again."""


class Handlers:
    """Coroutines that answer; what they may touch of `work` without the loop are its tables."""

    def __init__(self, robot: Robot, work: Work) -> None:
        self._robot = robot
        self._work = work
        self._editor = Editor(robot, work.motors, work.buttons)

    async def motor(self, ask: Ask) -> Reply:
        """List, show or move."""
        query = _query(ask)

        def require(role: Role) -> None:
            _refuse_head(ask)
            ask.require(role)

        wanted = deciding.flag(query, "measured") if "id" in query or "measured" in query else False
        answer: MotorAnswer = await self._promised(lambda: self._work.motor(query, require, measured=wanted))
        return web.json(answer)

    async def several(self, ask: Ask) -> Reply:
        """Move several."""
        _refuse_head(ask)
        body = _body(ask)
        answer: MultiAnswer = await self._promised(lambda: self._work.several(body, _query(ask)))
        return web.json(answer)

    async def motions(self, ask: Ask) -> Reply:
        """List them."""
        del ask
        return web.json(MotionsAnswer(self._work.buttons.all()))

    async def play(self, ask: Ask) -> Reply:
        """Play one."""
        _refuse_head(ask)
        answer: PlayedAnswer = await self._promised(lambda: self._work.play(ask.keys["key"]))
        return web.json(answer)

    async def jobs(self, ask: Ask) -> Reply:
        """List them."""
        del ask
        return web.json(JobsReply(await self._robot.call(self._work.jobs.all)))

    async def job(self, ask: Ask) -> Reply:
        """Show one."""
        return web.json(JobReply(await self._robot.call(lambda: self._work.jobs.get(ask.keys["job"]))))

    async def cancel(self, ask: Ask) -> Reply:
        """Cancel one."""
        return web.json(JobReply(await self._robot.call(lambda: self._work.jobs.cancel(ask.keys["job"]))))

    async def show_motor(self, ask: Ask) -> Reply:
        """Show a row."""
        return _row(await self._editor.show_motor(ask.keys["id"]))

    async def show_motion(self, ask: Ask) -> Reply:
        """Show a row."""
        return _row(await self._editor.show_motion(ask.keys["id"]))

    async def add_motor(self, ask: Ask) -> Reply:
        """Make a row."""
        return _row(await self._editor.add_motor(ask, ask.data), 201)

    async def change_motor(self, ask: Ask) -> Reply:
        """Change a row."""
        return _row(await self._editor.change_motor(ask, ask.keys["id"], ask.data))

    async def add_motion(self, ask: Ask) -> Reply:
        """Make a row."""
        return _row(await self._editor.add_motion(ask, ask.data), 201)

    async def change_motion(self, ask: Ask) -> Reply:
        """Change a row."""
        return _row(await self._editor.change_motion(ask, ask.keys["id"], ask.data))

    async def _promised(self, work: Callable[[], Promise[Any]]) -> Any:
        return await self._robot.promised(work, timeout_s=ANSWER_S)


async def ok(ask: Ask) -> Reply:
    """Say that it is there."""
    del ask
    return web.text("OK")


def _refuse_head(ask: Ask) -> None:
    """Whoever only wants to know what there is moves nothing."""
    if ask.method == "HEAD":
        raise web.Refused(405, "HEAD moves nothing: use GET or POST", {"Allow": "GET, POST"})


def _row(answer: MotorRowAnswer | MotionRowAnswer, status: int = 200) -> Reply:
    return web.json(answer, status, ETag=f'"{answer.version}"')


def _query(ask: Ask) -> deciding.Query:
    found: dict[str, list[str]] = {}
    for name, value in ask.query:
        found.setdefault(name, []).append(value)
    return found


def _body(ask: Ask) -> Any:
    """Return what a body says, whatever that is; refuse none, other kinds of it, and what is no JSON."""
    media = ask.headers.get("content-type", "").partition(";")[0].strip().lower()
    if not ask.body:
        raise web.Refused(400, f"a body is needed: {deciding.EXAMPLE}, as application/json")
    if media != web.JSON:
        raise web.Refused(400, f"the body must be application/json, not '{media[:60]}'")
    try:
        return msgspec.json.decode(ask.body)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as err:
        raise web.Refused(400, f"the body is no JSON: {err}") from None
