"""The robot's body as a face: what a page draws it and its motions from, with the limits of its joints."""

from typing import TYPE_CHECKING

from lbr.apps.web.ports import FacePorts
from lbr.messages.joints import Joint, MotionRow, MotionStep
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor

if TYPE_CHECKING:
    from lbr.apps.web.face import Face
    from lbr.apps.web.robot import Robot

PORTS = FacePorts(rows=(Joint, Wheel, RangeSensor, MotionRow, MotionStep), edits=(MotionRow, MotionStep))


def face(robot: "Robot") -> "Face":
    """Return the face."""
    from lbr.apps.web.model.routes import ModelFace  # noqa: PLC0415 - who wants its ports alone needs no server

    return ModelFace(robot)
