"""The robot's cameras as a face: a page, a stream, the newest picture; for who shows a token or has signed in."""

from lbr.apps.web.face import Face
from lbr.apps.web.robot import Robot


def face(robot: Robot) -> Face:
    """Return the face."""
    from lbr.apps.web.cameras.ports import Ports  # noqa: PLC0415 - who wants a part of it needs no more
    from lbr.apps.web.cameras.routes import CamerasFace  # noqa: PLC0415

    return CamerasFace(Ports(robot))
