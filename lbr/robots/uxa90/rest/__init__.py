"""The UXA-90's API, unchanged for its phone app and people's scripts, with later additions."""

from lbr.apps.web.ports import FacePorts
from lbr.messages.faces import Button, Motor
from lbr.messages.joints import MotionRow, MotionStep
from lbr.robots.uxa90.driver.messages import ControllerState, TakeControlCommand

PORTS = FacePorts(
    inputs={"controller": ControllerState},
    states=("controller",),
    requests={"take_control": TakeControlCommand},
    rows=(MotionRow, MotionStep, Motor, Button),
    edits=(MotionRow, MotionStep, Motor, Button),
)
