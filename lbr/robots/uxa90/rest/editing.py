"""The routes that create and change motors and motions: from a request's body to rows, and from rows to an answer."""

from collections.abc import Mapping
from typing import Annotated, NoReturn

from starlette.responses import Response

from lbr.apps.web import face as web
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Refused, Request, get, post, route
from lbr.apps.web.robot import Robot
from lbr.messages.codes import heard
from lbr.messages.faces import Button, EditCommand, EditReply, Motor
from lbr.messages.joints import Joint, KeyFrame, Motion
from lbr.messages.rows import Row
from lbr.robots.uxa90.rest.bodies import (
    Frame,
    FrameBody,
    MotionBody,
    MotionRow,
    MotionRowAnswer,
    MotorBody,
    MotorRow,
    MotorRowAnswer,
    NewMotorBody,
)
from lbr.robots.uxa90.rest.buttons import ButtonTable
from lbr.robots.uxa90.rest.counts import joint_rad
from lbr.robots.uxa90.rest.table import MotorTable

FIRST_OWN_ID = 100
LAST_ID = 9999
REVISION_S = 2.0
BUILT_IN = "is built in"
SLACK_RAD = 1e-3
EDIT_S = 7.0
EDIT = Refuses(
    {
        400: "The body makes no sense.",
        403: "It is built in.",
        404: "It is not there.",
        409: "It cannot be so.",
        412: "It was changed since the version that was quoted.",
    }
)
NO_ROW = Refuses({404: "it is not there"})


class Editor:
    """Writes rows through the executive, and keeps the tables of this face in step with them."""

    def __init__(self, robot: Robot, motors: MotorTable, buttons: ButtonTable) -> None:
        self._robot = robot
        self._motors = motors
        self._buttons = buttons
        self._known_revision = 0

    @get("/motors/{id}", within_s=EDIT_S)
    async def show_motor(self, id_: str) -> Annotated[Response, {200: MotorRowAnswer}, NO_ROW]:
        """Read a motor's row."""
        return self._motor_answer(self._motor(id_), await self._revision())

    @post("/motors", role="admin", within_s=EDIT_S)
    async def add_motor(self, request: Request, body: NewMotorBody) -> Annotated[Response, {201: MotorRowAnswer}, EDIT]:
        """Create a motor."""
        if body.id in self._motors.motors:
            raise Refused(409, f"Motor '{body.id}' exists already; PUT /motors/{body.id} changes it", code="exists")
        return await self._write_motor(request, body, body.id, create=True)

    @route("PUT", "/motors/{id}", role="admin", within_s=EDIT_S)
    async def change_motor(
        self, request: Request, id_: str, body: MotorBody
    ) -> Annotated[Response, {200: MotorRowAnswer}, EDIT]:
        """Change a motor that is not built in."""
        motor = self._motor(id_)
        if motor.builtin:
            raise Refused(
                403, f"Motor '{motor.id}' {BUILT_IN}: give the web server a layer of your own instead", code="read_only"
            )
        return await self._write_motor(request, body, motor.id, create=False)

    @get("/motions/{id}", within_s=EDIT_S)
    async def show_motion(self, id_: str) -> Annotated[Response, {200: MotionRowAnswer}, NO_ROW]:
        """Read a motion's row and its key frames; plays nothing."""
        return self._motion_answer(self._button(id_), await self._revision())

    @post("/motions", role="admin", within_s=EDIT_S)
    async def add_motion(self, request: Request, body: MotionBody) -> Annotated[Response, {201: MotionRowAnswer}, EDIT]:
        """Create a motion of key frames."""
        number = self._free() if body.id is None else body.id
        if number in self._buttons.buttons:
            raise Refused(409, f"Motion '{number}' exists already; PUT /motions/{number} changes it", code="exists")
        if self._robot.motion(body.name) is not None:
            raise Refused(409, f"A motion '{body.name}' exists already", code="exists")
        return await self._write_motion(request, body, number, create=True)

    @route("PUT", "/motions/{id}", role="admin", within_s=EDIT_S)
    async def change_motion(
        self, request: Request, id_: str, body: MotionBody
    ) -> Annotated[Response, {200: MotionRowAnswer}, EDIT]:
        """Change a motion that is not built in."""
        button = self._button(id_)
        if button.builtin:
            raise Refused(
                403, f"Motion '{button.id}' {BUILT_IN}: make one of your own (POST /motions)", code="read_only"
            )
        if body.id not in {None, button.id}:
            raise Refused(400, f"the body's id {body.id} is not that of the path, {button.id}")
        if body.name != button.motion:
            raise Refused(400, f"a motion keeps its name, '{button.motion}'; make another one (POST /motions)")
        return await self._write_motion(request, body, button.id, create=False)

    async def _write_motor(self, request: Request, body: MotorBody, number: int, *, create: bool) -> Response:
        if not body.lowest <= body.rest <= body.highest or body.lowest >= body.highest:
            raise Refused(400, "min must be less than max, and default between them")
        if number not in self._motors.joints:
            raise Refused(400, f"no joint is turned by a servo {number}: there is no row of `joint` for it")
        motor = Motor(
            layer=self._robot.settings.layer,
            id=number,
            name=body.name,
            description=body.description,
            initial=body.rest if body.position is None else body.position,
            lowest=body.lowest,
            highest=body.highest,
            rest=body.rest,
            inverted=body.inverted,
        )
        reply = await self._write(request, (motor,), body.version, create=create)
        self._motors.put(motor)
        return self._motor_answer(motor, reply.revision, 201 if create else 200)

    async def _write_motion(self, request: Request, body: MotionBody, number: int, *, create: bool) -> Response:
        joints = {joint.name: joint for joint in self._robot.joints}
        frames = tuple(_frame(frame, at, joints, self._motors.joints) for at, frame in enumerate(body.frames))
        motion = Motion(name=body.name, frames=frames, help=body.help)
        button = Button(id=number, name=body.name, button=body.button, motion=body.name)
        reply = await self._write(request, (*motion.rows, button), body.version, create=create)
        self._buttons.put(button)
        return self._motion_answer(button, reply.revision, 201 if create else 200)

    async def _write(self, request: Request, rows: tuple[Row, ...], version: int | None, *, create: bool) -> EditReply:
        quoted = _if_match(request.headers)
        revision = version if quoted is None else quoted
        reply = await self._robot.edit(rows, create=create, revision=revision, by=str(request.client)[:80])
        self._known_revision = max(self._known_revision, reply.revision)
        if not reply.accepted:
            _refuse(reply)
        return reply

    async def _revision(self) -> int:
        """Return the newest revision of the rows, from the refusal of an edit without rows.

        Without an answer it is the last known one: a client that quotes it may be refused, but overwrites nothing.
        """
        try:
            reply: EditReply = await self._robot.ask("edit", EditCommand(), timeout_s=REVISION_S)
        except Refused:
            return self._known_revision
        self._known_revision = reply.revision
        return reply.revision

    def _motor(self, key: str) -> Motor:
        motor = self._motors.motors.get(int(key)) if _is_id(key) else None
        if motor is None:
            raise Refused(404, f"Motor '{key[:40]}' doesn't exist")
        return motor

    def _button(self, key: str) -> Button:
        button = self._buttons.buttons.get(int(key)) if _is_id(key) else None
        if button is None:
            raise Refused(404, f"Motion '{key[:40]}' doesn't exist")
        return button

    def _free(self) -> int:
        found = next((n for n in range(FIRST_OWN_ID, LAST_ID + 1) if n not in self._buttons.buttons), None)
        if found is None:
            raise Refused(409, "all numbers for motions are taken", code="limit")
        return found

    def _motor_answer(self, motor: Motor, revision: int, status: int = 200) -> Response:
        joint = self._motors.joints.get(motor.id)
        row = MotorRow(
            id=motor.id,
            name=motor.name,
            description=motor.description,
            position=motor.initial,
            min=motor.lowest,
            max=motor.highest,
            default=motor.rest,
            inverted=motor.inverted,
            layer=motor.layer,
            builtin=motor.builtin,
            joint=joint.name if joint is not None else None,
        )
        return _answer(MotorRowAnswer(row, revision), status)

    def _motion_answer(self, button: Button, revision: int, status: int = 200) -> Response:
        motion = self._robot.motion(button.motion)
        frames = () if motion is None else motion.frames
        slot_s = None if motion is None else motion.slot_s
        row = MotionRow(
            id=button.id,
            name=button.name,
            button=button.button,
            motion=button.motion or "",
            help=motion.help if motion is not None else "",
            builtin=button.builtin or (motion is not None and motion.builtin),
            slot=motion.slot if motion is not None else None,
            duration_s=round(sum(frame.duration_s for frame in frames) if slot_s is None else slot_s, 3),
            frames=[Frame(frame.duration_s, dict(frame.positions)) for frame in frames],
        )
        return _answer(MotionRowAnswer(row, revision), status)


def _frame(frame: FrameBody, at: int, joints: Mapping[str, Joint], by_id: Mapping[int, Joint]) -> KeyFrame:
    """Return a key frame in joint radians; refuse unknown joints and angles beyond their limits."""
    positions = dict(frame.positions)
    for key, count in frame.counts.items():
        joint = by_id.get(int(key)) if _is_id(key) else None
        if joint is None:
            raise Refused(400, f"frames[{at}].counts: no joint is turned by a servo '{key[:20]}'")
        if joint.name in positions:
            raise Refused(400, f"frames[{at}]: {joint.name} is in positions and in counts")
        positions[joint.name] = round(joint_rad(joint, count), 4)
    if not positions:
        raise Refused(400, f"frames[{at}] moves nothing: give positions (radians) or counts")
    for name, angle_rad in positions.items():
        if name not in joints:
            raise Refused(400, f"frames[{at}].positions: there is no joint '{name[:40]}'")
        joint = joints[name]
        if not joint.lower_rad - SLACK_RAD <= angle_rad <= joint.upper_rad + SLACK_RAD:
            limits = f"{joint.lower_rad:g} to {joint.upper_rad:g}"
            raise Refused(400, f"frames[{at}]: {angle_rad:g} rad is outside what {name} may do ({limits})")
        positions[name] = min(max(angle_rad, joint.lower_rad), joint.upper_rad)
    return KeyFrame(positions=positions, duration_s=frame.duration_s)


def _answer(answer: MotorRowAnswer | MotionRowAnswer, status: int) -> Response:
    return web.json(answer, status, ETag=f'"{answer.version}"')


def _if_match(headers: Mapping[str, str]) -> int | None:
    """Return the version of an `If-Match` header, if there is one; `*` matches any."""
    quoted = headers.get("if-match", "").strip()
    if quoted in {"", "*"}:
        return None
    version = quoted.removeprefix("W/").strip('"')
    if not _is_id(version):
        raise Refused(400, 'If-Match must quote the version of an earlier answer, such as "12"')
    return int(version)


def _refuse(reply: EditReply) -> NoReturn:
    status = {"changed": 412, "read_only": 403}.get(reply.code, 409)
    raise Refused(status, heard(reply.code, reply.reason))


def _is_id(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) <= len(str(LAST_ID)) + 3
