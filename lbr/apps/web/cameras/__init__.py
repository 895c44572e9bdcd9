"""The robot's cameras as a face: a page, a stream, the newest picture; for clients with a token or signed in."""

from typing import TYPE_CHECKING

from lbr.apps.web.ports import FacePorts
from lbr.messages.camera import CameraState, JpegFrame

if TYPE_CHECKING:
    from lbr.apps.web.face import Face
    from lbr.apps.web.robot import Robot

PORTS = FacePorts(inputs={"cameras": CameraState, "frames": JpegFrame})


def face(robot: "Robot") -> "Face":
    """Return the face."""
    from lbr.apps.web.cameras.ports import Ports  # noqa: PLC0415 - who wants its ports alone needs no server
    from lbr.apps.web.cameras.routes import CamerasFace  # noqa: PLC0415

    return CamerasFace(Ports(robot))
