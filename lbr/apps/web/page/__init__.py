"""The page that the robot serves of itself, as a face: what was built of the sources beside this into `dist/`."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lbr.apps.web.face import Face
    from lbr.apps.web.robot import Robot


def face(robot: "Robot") -> "Face":
    """Return the face."""
    from lbr.apps.web.page.files import PageFace, built  # noqa: PLC0415 - who wants its name alone needs no server

    del robot
    return PageFace(built())
