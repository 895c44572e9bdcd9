"""Answers what the robot's body is made of; made once, and again when its file has changed."""

from hashlib import blake2b
from pathlib import Path

import msgspec
from starlette.responses import Response

from lbr.apps.web.face import Face, Request, Route, encoded
from lbr.apps.web.robot import Robot
from lbr.bodies.model import body_file, model
from lbr.bodies.parts import RobotModel
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor


class ModelFace(Face):
    """A robot's rows do not change while the server runs: a change of theirs starts it again."""

    name = "model"

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._made: tuple[object, bytes, str] | None = None

    def routes(self) -> tuple[Route, ...]:
        """Return the one."""
        return (
            Route(
                method="GET",
                path="/api/model",
                handle=self._model,
                summary="The robot's body: links, joints with their limits, shapes, sensors",
                description="Metres and radians; x ahead, y left, z up. With `If-None-Match` it says 304 if nothing changed.",
                replies={200: RobotModel, 304: None},
            ),
        )

    def _model(self, request: Request) -> Response:
        content, tag = self._newest()
        if request.headers.get("if-none-match") == tag:
            return Response(status_code=304, headers={"etag": tag, "cache-control": "no-cache"})
        return encoded(content, etag=tag, cache_control="no-cache")

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
