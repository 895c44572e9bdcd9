"""Drive operations: one holder, leases, rules, limits and bounded moves between drive commands and the motors."""

from lbr.capability.kind import Command, Kind, Known
from lbr.capability.word import Word
from lbr.messages.attitude import AttitudeState
from lbr.messages.drive import (
    CheckRequest,
    CheckVerdict,
    DriveCommand,
    DriveState,
    GoalResult,
    HeadingCommand,
    TurnCommand,
    TwistCommand,
)
from lbr.messages.kinematics import Kinematics, Wheel
from lbr.messages.leases import StopCommand
from lbr.messages.motors import MotorSetpoint, MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges, RangeSensor, Scan
from lbr.operations.drive.settings import DriveSettings


def _single_ray(known: Known) -> set[str]:
    """Return the sensors to whose distance a motion may be bounded: those with one ray."""
    return {row.name for row in known.rows(RangeSensor) if row.rays == 1}


KIND = Kind(
    name="drive",
    summary="decides what the wheels of the base do, for whom, and for how long",
    family="operation",
    entry="lbr.operations.drive.capability:Drive",
    settings=DriveSettings,
    inputs={
        "ranges": Ranges,
        "scans": Scan,
        "motors": MotorsState,
        "attitude": AttitudeState,
        "odometry": OdometryState,
    },
    outputs={"setpoint": MotorSetpoint, "state": DriveState, "result": GoalResult},
    commands={
        "command": Command(DriveCommand, leased=True, choices={"sensor": _single_ray}),
        "turn": Command(TurnCommand, leased=True),
        "heading": Command(HeadingCommand, leased=True),
        "twist": Command(TwistCommand, leased=True),
        "stop": StopCommand,
    },
    replies={"checks": CheckVerdict},
    requests={"checks": CheckRequest},
    rows=(RangeSensor, Kinematics, Wheel),
    optional=("scans",),
    moves=True,
    words=(
        Word(
            "/r/{power}/{angle_deg}",
            "command",
            "Drive: power 0 to 1 of full, angle in degrees clockwise (0 ahead, 90 right, 180 back, 270 left)",
        ),
        Word(
            "/r/{power}/{angle_deg}/{range_cm}/{sensor}/{interval_s}",
            "command",
            "Drive until a sensor, such as forward, back, left or right, reads the range, 0 to 769 cm, "
            "or the time is over, 0 to 3600 s; 0 sets no bound",
        ),
        Word(
            "/go/{distance_cm}/{power}",
            "command",
            "Drive straight ahead by a distance, 1 to 10000 cm, such as /go/150/0.3, and stop",
            {"angle_deg": 0},
        ),
        Word(
            "/back/{distance_cm}/{power}",
            "command",
            "Drive straight back by a distance, 1 to 10000 cm, such as /back/50/0.2",
            {"angle_deg": 180},
        ),
        Word(
            "/t/{angle_deg}",
            "turn",
            "Turn on the spot by an angle, -360 to 360 degrees, clockwise positive, such as /t/90 or /t/-45",
        ),
        Word(
            "/h/{heading_deg}",
            "heading",
            "Turn on the spot to a compass heading, 0 to 360 degrees (0 north, 90 east), the shorter way",
        ),
        Word(
            "/twist/{vx_mps}/{vy_mps}/{wz_rps}",
            "twist",
            "Move by a twist: m/s ahead, m/s to the left (0 unless the base can), rad/s anticlockwise, "
            "such as /twist/0.3/0/0.5",
        ),
    ),
)
