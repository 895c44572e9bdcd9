"""The robot's body as a face: the model of body, joint limits and motions that a page draws."""

from lbr.apps.web.ports import FacePorts
from lbr.messages.joints import Joint, MotionRow, MotionStep
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor

PORTS = FacePorts(rows=(Joint, Wheel, RangeSensor, MotionRow, MotionStep), edits=(MotionRow, MotionStep))
