"""The robot's body as a face: what a page draws it and its motions from, with the limits of its joints."""

from lbr.apps.web.ports import FacePorts
from lbr.messages.joints import Joint, MotionRow, MotionStep
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor

PORTS = FacePorts(rows=(Joint, Wheel, RangeSensor, MotionRow, MotionStep), edits=(MotionRow, MotionStep))
