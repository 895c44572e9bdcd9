"""The call as a face: a page rings, keeps its call and leaves it; picture and sound go past this server."""

from typing import TYPE_CHECKING

from lbr.apps.call.messages import KeepCommand, RingCommand, RingReply
from lbr.apps.web.ports import FacePorts

if TYPE_CHECKING:
    from lbr.apps.web.face import Face
    from lbr.apps.web.robot import Robot

PORTS = FacePorts(
    requests={"call_ring": RingCommand, "call_keep": KeepCommand},
    replies={"call_ring": RingReply, "call_keep": RingReply},
)


def face(robot: "Robot") -> "Face":
    """Return the face."""
    from lbr.apps.call.face.routes import CallFace  # noqa: PLC0415 - who wants its ports alone needs no server

    return CallFace(robot)
