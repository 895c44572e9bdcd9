"""The UXA-90's API, as its phone app and people's scripts have known it, and what was added to it since."""

from typing import TYPE_CHECKING

from lbr.apps.web.ports import FacePorts
from lbr.messages.faces import Button, Motor
from lbr.messages.joints import MotionRow, MotionStep
from lbr.robots.uxa90.driver.messages import ControllerState, TakeControlCommand

if TYPE_CHECKING:
    from lbr.apps.web.face import Face
    from lbr.apps.web.robot import Robot

PORTS = FacePorts(
    inputs={"controller": ControllerState},
    states=("controller",),
    requests={"take_control": TakeControlCommand},
    rows=(MotionRow, MotionStep, Motor, Button),
    edits=(MotionRow, MotionStep, Motor, Button),
)


def face(robot: "Robot") -> "Face":
    """Return the face."""
    from lbr.robots.uxa90.rest.legacy import Uxa90Face  # noqa: PLC0415 - who wants its ports alone needs no server

    return Uxa90Face(robot)
