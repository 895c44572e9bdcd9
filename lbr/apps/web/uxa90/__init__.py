"""The UXA-90's API, as its phone app and people's scripts have known it, and what was added to it since."""

from lbr.apps.web.face import Face
from lbr.apps.web.robot import Robot


def face(robot: Robot) -> Face:
    """Return the face."""
    from lbr.apps.web.uxa90.legacy import Uxa90Face  # noqa: PLC0415 - whoever wants a part of it needs no server

    return Uxa90Face(robot)
