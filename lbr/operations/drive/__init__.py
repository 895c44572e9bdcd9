"""Drive operations: one holder, leases, rules, limits and bounded moves between drive commands and the motors."""

from lbr.capability.kind import Command, Kind
from lbr.messages.attitude import AttitudeState
from lbr.messages.drive import (
    CheckRequest,
    CheckVerdict,
    DriveCommand,
    DriveState,
    GoalResult,
    HeadingCommand,
    TurnCommand,
)
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
    commands={
        "command": Command(DriveCommand, leased=True),
        "turn": Command(TurnCommand, leased=True),
        "heading": Command(HeadingCommand, leased=True),
        "stop": StopCommand,
    },
    replies={
        **dict.fromkeys(("command", "turn", "heading", "stop"), CommandReply),
        "checks": CheckVerdict,
    },
    requests={"checks": CheckRequest},
    moves=True,
)
