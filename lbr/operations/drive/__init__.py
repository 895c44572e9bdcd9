"""Drive operations: one holder, leases, rules, limits and bounded moves between drive commands and the motors."""

from lbr.capability.kind import Kind
from lbr.messages.drive import (
    CheckRequest,
    CommandReply,
    DriveCommand,
    DriveState,
    GoalResult,
    StopCommand,
)
from lbr.messages.motors import MotorSetpoint, MotorsState
from lbr.messages.sensing import Ranges
from lbr.operations.drive.settings import DriveSettings

KIND = Kind(
    name="drive",
    summary="decides what the two wheels of the base do, for whom, and for how long",
    family="operation",
    entry="lbr.operations.drive.capability:Drive",
    settings=DriveSettings,
    inputs={"ranges": Ranges, "motors": MotorsState},
    outputs={"setpoint": MotorSetpoint, "state": DriveState, "result": GoalResult},
    commands={"command": DriveCommand, "stop": StopCommand},
    replies={"command": CommandReply, "stop": CommandReply},
    requests={"checks": CheckRequest},
    moves=True,
)
