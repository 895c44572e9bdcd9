"""The requests of the page's motion builder: check the balance, read and write files, list earlier versions."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Annotated, TypeVar

import msgspec
from msgspec import Meta, Struct

from lbr import home
from lbr.apps.bodies import motion_forms
from lbr.apps.web.bridge import until
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Client, Refused, get, post, route
from lbr.apps.web.model.uploads import MOST_PACKED, Uploads
from lbr.apps.web.model.work import BUSY, SHORT_S, Work, Works
from lbr.apps.web.robot import Robot
from lbr.apps.web.routing import decoded
from lbr.errors import LbrError
from lbr.messages.codes import Code
from lbr.messages.joints import JointRad, Motion
from lbr.messages.motion_work import (
    BalanceReport,
    Checked,
    CheckJob,
    Frames,
    Job,
    JobMessage,
    NotDone,
    ReadJob,
    ReadMotions,
    Versions,
    VersionsJob,
    WriteJob,
    Written,
)
from lbr.messages.units import Name

LARGEST_PART = 48_000
T = TypeVar("T", bound=JobMessage)
UploadName = Annotated[
    str, Meta(pattern="^[A-Za-z0-9-]{1,40}$(?!\\n)", description="the sender's own name for what it sends")
]
SLOW = Refuses({503: "Too much is under way, or it took too long."})
NOT_WRITTEN = Refuses({400: "That form is only read, or cannot say it.", 404: "What was sent in parts is not there."})
NO_MOTION = Refuses({404: "There is no such motion, or what was sent in parts is not there."})
NO_CHECK = Refuses({404: "There is no such check."})
STATUS: Mapping[str, int] = {"busy": 503, "timeout": 503, "failed": 500, "cancelled": 410, "shutting_down": 503}


class UploadBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A part of an upload, counted from 0; the whole is packed by gzip."""

    upload: UploadName
    part: Annotated[int, Meta(ge=0, le=MOST_PACKED)] = 0
    content: Annotated[bytes, Meta(max_length=LARGEST_PART)]


class Uploaded(Struct, frozen=True, kw_only=True):
    """The progress of an upload."""

    bytes: int


class ReadBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A file sent in parts, and its name, whose suffix is the form."""

    upload: UploadName
    file: Annotated[str, Meta(max_length=200)]


class MotionGiven(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A motion on a page, which need not be stored."""

    name: Name = "motion"
    help: Annotated[str, Meta(max_length=200)] = ""
    frames: Frames


class MotionMeant(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A motion, as an uploaded `MotionGiven` or by its name."""

    upload: UploadName | None = None
    motion: Name | None = None


class WriteBody(MotionMeant, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A motion, and the form of its file."""

    form: Annotated[str, Meta(max_length=11)] = ".json"


class CheckBody(MotionMeant, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A motion; `start` is the joints' position before it."""

    start: dict[str, JointRad] = {}


class Check(Struct, frozen=True, kw_only=True):
    """A check under way: its number, its progress from 0 to 1, and the report once it is done."""

    check: int
    part: float = 0.0
    report: BalanceReport | None = None


class CheckParams(Struct, frozen=True, kw_only=True):
    """Which check."""

    check: int


class MotionParams(Struct, frozen=True, kw_only=True):
    """Which motion."""

    motion: Annotated[str, Meta(max_length=40)]


class Form(Struct, frozen=True, kw_only=True):
    """A form of motion files, by its suffix; `writes`: it can be written, too."""

    suffix: str
    summary: str
    writes: bool


class Forms(Struct, frozen=True, kw_only=True):
    """The forms of motion files."""

    forms: tuple[Form, ...]


class Building:
    """The routes of the builder, and their jobs."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._works = Works(robot.now)
        self._uploads = Uploads(robot.now)
        self._checks: dict[int, tuple[str, Work]] = {}
        self._number = 0

    def step(self) -> None:
        """Step the jobs under way."""
        self._works.step()

    def close(self) -> None:
        """End the jobs under way."""
        self._works.close()
        self._checks.clear()

    @property
    def jobs(self) -> int:
        """Return the number of jobs under way."""
        return self._works.count

    def given(self, client: Client, upload: str) -> MotionGiven:
        """Return the motion in a client's upload; raise Refused if it is missing or malformed."""
        found: MotionGiven = decoded(self._uploads.take(str(client), upload), MotionGiven)
        return found

    def stored(self, name: str) -> Motion:
        """Return a stored motion; raise Refused for an unknown name."""
        if (motion := self._robot.motion(name)) is None:
            raise Refused(404, f"there is no motion '{name}'")
        return motion

    @post("/api/motion/upload", role="operate")
    async def _upload(
        self, client: Client, body: UploadBody
    ) -> Annotated[Uploaded, Refuses({409: "A part is missing before this one.", 503: "Too much is sent at once."})]:
        """Upload a file larger than a body, in parts. Each part is base64 of a piece of the gzip file. It is kept for a
        minute, for the request that names it."""
        return Uploaded(bytes=self._uploads.add(str(client), body.upload, body.part, body.content))

    @get("/api/motion/forms")
    def _forms(self) -> Forms:
        """The forms of motion files, for reading and writing."""
        known = motion_forms.known(self._robot.name)
        return Forms(forms=tuple(Form(suffix=s, summary=t, writes=w) for s, t, w in known))

    @post("/api/motion/read", role="operate", within_s=SHORT_S + 1.0)
    async def _read(
        self, client: Client, body: ReadBody
    ) -> Annotated[ReadMotions, Refuses({400: "It is no motion, or none of this robot's."}), SLOW]:
        """Read the motions in a file, for this robot's joints; nothing is stored."""
        job = ReadJob(
            content=self._uploads.take(str(client), body.upload),
            suffix=Path(body.file).suffix.lower(),
            joints=self._robot.joints,
            motors=self._robot.motors,
        )
        return await self._done(job, ReadMotions)

    @post("/api/motion/write", role="operate", within_s=SHORT_S + 1.0)
    async def _write(self, client: Client, body: WriteBody) -> Annotated[Written, NOT_WRITTEN, SLOW]:
        """Write a motion as a file, in base64, and list what its form cannot express."""
        job = WriteJob(
            robot=self._robot.name,
            motion=self._meant(client, body),
            suffix=body.form.lower(),
            joints=self._robot.joints,
            motors=self._robot.motors,
        )
        return await self._done(job, Written)

    @get("/api/motion/versions", within_s=SHORT_S + 1.0)
    async def _versions(self, params: MotionParams) -> Annotated[Versions, SLOW]:
        """The earlier versions of a motion, newest first."""
        job = VersionsJob(robot=self._robot.name, database=self._database(), motion=params.motion)
        return await self._done(job, Versions)

    @post("/api/motion/check", role="operate")
    async def _check(self, client: Client, body: CheckBody) -> Annotated[Check, NO_MOTION, SLOW]:
        """Play a motion with the simulated body, to check whether it keeps its balance. It moves no robot. Poll for its
        progress; a check without a poll for 5 s is cancelled."""
        motion = self._meant(client, body)
        lead_in = self._robot.motion(motion.lead_in)
        job = CheckJob(
            robot=self._robot.name,
            home=self._robot.ctx.home,
            database=self._database(),
            joints=self._robot.joints,
            frames=motion.frames,
            lead_in=lead_in.frames if lead_in is not None else (),
            start=body.start,
        )
        owner = str(client)
        for number, (whose, work) in tuple(self._checks.items()):
            if whose == owner or work.result is not None:
                work.end(work.result or NotDone(reason="another was asked for", code="cancelled"))
                del self._checks[number]
        work_ = self._works.start(job, asked=True)
        if work_ is None:
            raise _refused(BUSY)
        self._number += 1
        self._checks[self._number] = owner, work_
        return Check(check=self._number)

    @get("/api/motion/check")
    async def _checked(
        self, client: Client, params: CheckParams
    ) -> Annotated[Check, NO_CHECK, Refuses({500: "It could not be done; the sentence has the reason."})]:
        """The progress of a check, and its report."""
        work = self._the_check(client, params.check)
        work.asked_s = self._robot.now()
        if isinstance(work.result, NotDone):
            raise _refused(work.result)
        report = work.result.report if isinstance(work.result, Checked) else None
        part = 1.0 if report is not None else work.part
        return Check(check=params.check, part=part, report=report)

    @route("DELETE", "/api/motion/check", role="operate")
    async def _cancel(self, client: Client, params: CheckParams) -> Annotated[Check, NO_CHECK]:
        """Cancel a check."""
        work = self._the_check(client, params.check)
        if work.result is None:
            work.end(NotDone(reason="it was cancelled", code="cancelled"))
        self._checks.pop(params.check, None)
        return Check(check=params.check, part=work.part)

    def _the_check(self, client: Client, check: int) -> Work:
        whose, work = self._checks.get(check, ("", None))
        if work is None or whose != str(client):
            raise Refused(404, f"there is no check {check} of yours: begin another")
        return work

    def _meant(self, client: Client, body: MotionMeant) -> Motion:
        """Return the motion of a request; an uploaded one gets the lead-in of the stored one of its name."""
        if body.upload is not None:
            given = self.given(client, body.upload)
            before = self._robot.motion(body.motion or given.name)
            lead_in = before.lead_in if before is not None else ""
            return Motion(name=given.name, frames=given.frames, help=given.help, lead_in=lead_in)
        motion = self.stored(body.motion or "")
        if motion.slot is not None:
            text = (
                f"'{motion.name}' is kept by the robot's controller, in slot {motion.slot}: there is no more of it here"
            )
            raise Refused(400, text, code="not_possible")
        return motion

    async def _done(self, job: Job, kind: type[T]) -> T:
        """Run a job, and return its result; raise Refused without one."""
        work = self._works.start(job)
        if work is None:
            raise _refused(BUSY)
        await until(lambda: work.result is not None)
        result = work.result
        if result is None or not isinstance(result, kind):
            raise _refused(result if isinstance(result, NotDone) else NotDone(reason="there is no result"))
        return result

    def _database(self) -> str:
        """Return the file of this robot's rows, from its run record."""
        with suppress(LbrError, OSError):
            for one in home.running():
                if one.robot == self._robot.name:
                    return one.database
        return str(Path(self._robot.ctx.home) / "robot.db")


def _refused(why: NotDone) -> Refused:
    try:
        code = msgspec.convert(why.code, Code)
    except msgspec.ValidationError:
        code = "failed"
    return Refused(STATUS.get(why.code, 400), why.reason, code=code)
