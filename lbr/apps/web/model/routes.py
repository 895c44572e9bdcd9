"""The model of the robot's body and the poses of its motions; made once, and again after a change."""

from hashlib import blake2b
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta, Struct
from msgspec.structs import replace
from starlette.responses import Response

from lbr.apps.bodies.model import body_file, model
from lbr.apps.bodies.parts import RobotModel
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Client, Face, Message, Refused, Request, Route, declared, encoded, get, post
from lbr.apps.web.model.building import Building, MotionParams, UploadName
from lbr.apps.web.model.poses import key_pose
from lbr.apps.web.robot import EDIT_S, Robot
from lbr.messages.codes import heard
from lbr.messages.joints import MAX_FRAMES, KeyFrame, Motion
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor
from lbr.messages.units import Name


class Poses(Struct, frozen=True, kw_only=True):
    """A characteristic pose of each motion, in radians by joint."""

    poses: dict[str, dict[str, float]]


class MotionBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A motion to store; with `replace` it replaces the motion of its name. A long one is uploaded first, and named by
    `upload`."""

    name: Name
    frames: Annotated[tuple[KeyFrame, ...], Meta(max_length=MAX_FRAMES)] = ()
    upload: UploadName | None = None
    help: Annotated[str, Meta(max_length=200)] = ""
    replace: bool = False


class ModelFace(Face):
    """The face of the body. Rows do not change while the server runs: a change of them restarts it."""

    name = "model"

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._made: tuple[object, bytes, str] | None = None
        self._drawn: tuple[object, bytes] | None = None
        self._building = Building(robot)

    def step(self, now: float) -> None:  # noqa: ARG002
        """Step the builder."""
        self._building.step()

    def close(self) -> None:
        """Close the builder."""
        self._building.close()

    @property
    def jobs(self) -> int:
        """Return the number of the builder's jobs."""
        return self._building.jobs

    def routes(self) -> list[Route]:
        """Return its routes and the builder's."""
        return [*declared(self), *declared(self._building)]

    @get("/api/model")
    def _model(self, request: Request) -> Annotated[Response, {200: RobotModel, 304: None}]:
        """The robot's body: links, joints with their limits, shapes, sensors. Metres and radians; x ahead, y left, z
        up. With `If-None-Match` the status is 304 if nothing changed."""
        content, tag = self._newest()
        if request.headers.get("if-none-match") == tag:
            return Response(status_code=304, headers={"etag": tag, "cache-control": "no-cache"})
        return encoded(content, etag=tag, cache_control="no-cache")

    @get("/api/poses")
    async def _poses(self) -> Annotated[Response, {200: Poses}]:
        """A characteristic pose of each motion."""
        motions = self._robot.motions
        if self._drawn is None or self._drawn[0] is not motions:
            poses = Poses(poses={one.name: pose for one in motions if (pose := key_pose(one))})
            self._drawn = motions, msgspec.json.encode(poses)
        return encoded(self._drawn[1])

    @get("/api/motion")
    async def _motion(self, params: MotionParams) -> Annotated[Motion, Refuses({404: "There is no such motion."})]:
        """A motion with all its key frames."""
        return self._building.stored(params.motion)

    @post("/api/motion", role="admin", within_s=EDIT_S + 1.0)
    async def _keep(
        self, client: Client, body: MotionBody
    ) -> Annotated[Message, Refuses({409: "It does not fit the robot, or there is one of this name."})]:
        """Store a motion in the robot's rows."""
        frames = body.frames if body.upload is None else self._building.given(client, body.upload).frames
        if not frames:
            raise Refused(400, f"motion '{body.name}' has no key frames")
        before = self._robot.motion(body.name)
        motion = Motion(name=body.name, frames=frames, help=body.help)
        if before is not None and body.replace:
            motion = replace(motion, lead_in=before.lead_in, lead_out=before.lead_out, help=body.help or before.help)
        reply = await self._robot.edit(motion.rows, create=not body.replace, by=str(client)[:80])
        if not reply.accepted:
            raise Refused(409, heard(reply.code, reply.reason))
        return Message(message=f"motion '{motion.name}' is kept")

    def _newest(self) -> tuple[bytes, str]:
        robot = self._robot
        file = body_file(robot.name, Path(robot.ctx.home))
        state = (file, _changed(file))
        if self._made is None or self._made[0] != state:
            found = model(robot.name, file, robot.joints, robot.ctx.rows(Wheel), robot.ctx.rows(RangeSensor))
            content = msgspec.json.encode(found)
            self._made = state, content, f'"{blake2b(content, digest_size=8).hexdigest()}"'
        return self._made[1:]


def _changed(file: Path | None) -> int:
    try:
        return file.stat().st_mtime_ns if file is not None else 0
    except OSError:
        return 0
