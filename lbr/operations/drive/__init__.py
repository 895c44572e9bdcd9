"""Drive operations: one holder, leases, rules, limits and bounded moves between drive commands and the motors."""

from lbr.capability.kind import Kind
from lbr.messages.attitude import AttitudeState
from lbr.messages.drive import CheckRequest, DriveCommand, DriveState, GoalResult, HeadingCommand, TurnCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.motors import MotorSetpoint, MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges
from lbr.operations.drive.settings import DriveSettings

KIND = Kind(
    name="drive",
    summary="decides what the two wheels of the base do, for whom, and for how long",
    family="operation",
    entry="lbr.operations.drive.capability:Drive",
    settings=DriveSettings,
    inputs={"ranges": Ranges, "motors": MotorsState, "attitude": AttitudeState, "odometry": OdometryState},
    outputs={"setpoint": MotorSetpoint, "state": DriveState, "result": GoalResult},
    commands={"command": DriveCommand, "turn": TurnCommand, "heading": HeadingCommand, "stop": StopCommand},
    replies={"command": CommandReply, "turn": CommandReply, "heading": CommandReply, "stop": CommandReply},
    requests={"checks": CheckRequest},
    moves=True,
)
