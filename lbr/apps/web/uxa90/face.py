"""The routes of the UXA-90's API, and the rounds of its loop: motors, motions, jobs and edits."""

from collections.abc import Callable, Mapping, Sequence
from importlib import resources
from typing import Any

import msgspec

from lbr.apps.web import face as web
from lbr.apps.web.bridge import Promise
from lbr.apps.web.face import Ask, Reply, Route
from lbr.apps.web.robot import Robot
from lbr.apps.web.uxa90 import deciding
from lbr.apps.web.uxa90.answers import MotionsAnswer, MotorAnswer, MultiAnswer, PlayedAnswer
from lbr.apps.web.uxa90.bodies import (
    MotionBody,
    MotionRowAnswer,
    MotorBody,
    MotorParams,
    MotorRowAnswer,
    MultiBody,
    MultiParams,
    NewMotorBody,
)
from lbr.apps.web.uxa90.editing import Editor
from lbr.apps.web.uxa90.jobs import JobReply, JobsReply
from lbr.apps.web.uxa90.work import Work
from lbr.messages.system import Role

REFUSED = {409: "it is not there, is busy, held by somebody else, or not allowed", 400: "the request makes no sense"}
EDIT = {400: "the body makes no sense", 403: "it is built in", 404: "it is not there", 409: "it cannot be so"}
CHANGED = {412: "it was changed since the version that was quoted"}


class Uxa90Face(web.Face):
    """Handlers are on the server's thread, and have the capability's loop do what there is to do (`Work`)."""

    name = "uxa90"

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._work = Work(robot)
        self._editor = Editor(robot, self._work.motors, self._work.buttons)

    def routes(self) -> Sequence[Route]:
        """Return what it answers."""
        return (*self._motor_routes(), *self._motion_routes(), *self._job_routes(), *self._row_routes(), *_pages())

    def step(self, now: float) -> None:
        """Renew what is borrowed, and begin what is due."""
        self._work.step(now)

    def stopped(self, reason: str) -> None:
        """Begin nothing of what waits."""
        self._work.stopped(reason)

    def state(self) -> Mapping[str, Any]:
        """Return what motors were told, what is busy, and the jobs that wait."""
        return self._work.state()

    @property
    def jobs(self) -> int:
        """How many wait."""
        return self._work.jobs.waiting

    def _motor_routes(self) -> Sequence[Route]:
        motor: dict[str, Any] = {
            "handle": self._motor,
            "summary": "List motors, read one, or move one",
            "description": "Without `id`: all. With `id`: that one. With `pos` as well: it moves (role operate).",
            "params": MotorParams,
            "replies": {200: MotorAnswer},
            "refuses": REFUSED,
            "lenient": True,
        }
        several: dict[str, Any] = {
            "handle": self._several,
            "summary": "Move several motors at once, or each after its delay",
            "description": "All of the list is looked at first: if anything is wrong with it, nothing moves.",
            "params": MultiParams,
            "body": MultiBody,
            "replies": {200: MultiAnswer},
            "refuses": REFUSED,
            "lenient": True,
            "role": "operate",
        }
        return (
            Route(
                method="GET", path="/", handle=_ok, summary="Say that it is there", replies={200: web.TEXT}, role=None
            ),
            Route(method="GET", path="/motor", **motor),
            Route(method="GET", path="/multimotor", **several),
            Route(method="POST", path="/multimotor", **several),
        )

    def _motion_routes(self) -> Sequence[Route]:
        play: dict[str, Any] = {
            "handle": self._play,
            "summary": "Play a motion, by number or name",
            "description": "It plays by itself after the answer; one at a time. 99, pc_control, only takes the main "
            "board over.",
            "replies": {200: PlayedAnswer},
            "refuses": REFUSED,
            "role": "operate",
        }
        return (
            Route(
                method="GET",
                path="/motion",
                handle=self._motions,
                summary="List motions",
                replies={200: MotionsAnswer},
            ),
            Route(method="GET", path="/motion/{key}", **play),
            Route(method="POST", path="/motion/{key}", **play),
        )

    def _job_routes(self) -> Sequence[Route]:
        missing = {404: "there is no such job"}
        return (
            Route(method="GET", path="/jobs", handle=self._jobs, summary="List jobs", replies={200: JobsReply}),
            Route(
                method="GET",
                path="/jobs/{job}",
                handle=self._job,
                summary="Read a job",
                replies={200: JobReply},
                refuses=missing,
            ),
            Route(
                method="DELETE",
                path="/jobs/{job}",
                handle=self._cancel,
                summary="Cancel a job: what has not begun does not begin",
                replies={200: JobReply},
                refuses={**missing, 409: "it is over"},
                role="operate",
            ),
        )

    def _row_routes(self) -> Sequence[Route]:
        motor: dict[str, Any] = {"replies": {200: MotorRowAnswer}, "refuses": {**EDIT, **CHANGED}, "role": "admin"}
        motion: dict[str, Any] = {"replies": {200: MotionRowAnswer}, "refuses": {**EDIT, **CHANGED}, "role": "admin"}
        created = {201: MotorRowAnswer}
        missing = {404: "it is not there"}
        return (
            Route(
                method="GET",
                path="/motors/{id}",
                handle=self._show_motor,
                summary="Read a motor's row",
                replies={200: MotorRowAnswer},
                refuses=missing,
            ),
            Route(
                method="POST",
                path="/motors",
                handle=self._add_motor,
                summary="Make a motor",
                body=NewMotorBody,
                **{**motor, "replies": created},
            ),
            Route(
                method="PUT",
                path="/motors/{id}",
                handle=self._change_motor,
                summary="Change a motor that is not built in",
                body=MotorBody,
                **motor,
            ),
            Route(
                method="GET",
                path="/motions/{id}",
                handle=self._show_motion,
                summary="Read a motion's row and its key frames; plays nothing",
                replies={200: MotionRowAnswer},
                refuses=missing,
            ),
            Route(
                method="POST",
                path="/motions",
                handle=self._add_motion,
                summary="Make a motion of key frames",
                body=MotionBody,
                **{**motion, "replies": {201: MotionRowAnswer}},
            ),
            Route(
                method="PUT",
                path="/motions/{id}",
                handle=self._change_motion,
                summary="Change a motion that is not built in",
                body=MotionBody,
                **motion,
            ),
        )

    async def _motor(self, ask: Ask) -> Reply:
        query = _query(ask)

        def require(role: Role) -> None:
            _refuse_head(ask)
            ask.require(role)

        wanted = deciding.flag(query, "measured") if "id" in query or "measured" in query else False
        answer: MotorAnswer = await self._promised(lambda: self._work.motor(query, require, measured=wanted))
        return web.json(answer)

    async def _several(self, ask: Ask) -> Reply:
        _refuse_head(ask)
        body = _body(ask)
        answer: MultiAnswer = await self._promised(lambda: self._work.several(body, _query(ask)))
        return web.json(answer)

    async def _motions(self, ask: Ask) -> Reply:
        del ask
        return web.json(MotionsAnswer(self._work.buttons.all()))

    async def _play(self, ask: Ask) -> Reply:
        _refuse_head(ask)
        answer: PlayedAnswer = await self._promised(lambda: self._work.play(ask.keys["key"]))
        return web.json(answer)

    async def _jobs(self, ask: Ask) -> Reply:
        del ask
        return web.json(JobsReply(await self._robot.call(self._work.jobs.all)))

    async def _job(self, ask: Ask) -> Reply:
        return web.json(JobReply(await self._robot.call(lambda: self._work.jobs.get(ask.keys["job"]))))

    async def _cancel(self, ask: Ask) -> Reply:
        return web.json(JobReply(await self._robot.call(lambda: self._work.jobs.cancel(ask.keys["job"]))))

    async def _show_motor(self, ask: Ask) -> Reply:
        return _row(await self._editor.show_motor(ask.keys["id"]))

    async def _show_motion(self, ask: Ask) -> Reply:
        return _row(await self._editor.show_motion(ask.keys["id"]))

    async def _add_motor(self, ask: Ask) -> Reply:
        return _row(await self._editor.add_motor(ask, ask.data), 201)

    async def _change_motor(self, ask: Ask) -> Reply:
        return _row(await self._editor.change_motor(ask, ask.keys["id"], ask.data))

    async def _add_motion(self, ask: Ask) -> Reply:
        return _row(await self._editor.add_motion(ask, ask.data), 201)

    async def _change_motion(self, ask: Ask) -> Reply:
        return _row(await self._editor.change_motion(ask, ask.keys["id"], ask.data))

    async def _promised(self, work: Callable[[], Promise[Any]]) -> Any:
        return await self._robot.promised(work, timeout_s=ANSWER_S)


ANSWER_S = 4.0
"""A motion's answer may need three others': the joints given back, motions, joints again."""


async def _ok(ask: Ask) -> Reply:
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


def _pages() -> Sequence[Route]:
    """Return the page with the buttons, and its parts."""
    parts = {
        "/demo": ("demo.html", web.HTML),
        "/demo.js": ("demo.js", "text/javascript"),
        "/demo.css": ("demo.css", "text/css"),
    }
    return tuple(
        Route(
            method="GET",
            path=path,
            handle=_page(name, media),
            summary="A page to move the head and to play motions",
            replies={200: media},
            role=None,
            page=True,
            hidden=path != "/demo",
        )
        for path, (name, media) in parts.items()
    )


def _page(name: str, media: str) -> Callable[[Ask], Any]:
    content = (resources.files("lbr.apps.web.uxa90") / "pages" / name).read_text()

    async def handle(ask: Ask) -> Reply:
        del ask
        return web.text(content, media=media)

    return handle
