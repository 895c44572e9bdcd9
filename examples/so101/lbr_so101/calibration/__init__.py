"""Calibration of an arm: a hand holds it at 0, then moves every joint to its ends; that gives its joint rows."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Command, Kind, Rows
from lbr.capability.word import Word
from lbr.messages.joints import BusOfJoints, Joint, MotionStep
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.servos import ServosState


class CalibrationSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of a row of kind `arm_calibration`."""

    bus: BusOfJoints = ""
    enough_rad: Annotated[float, Meta(ge=0.1, le=1.0, description="a joint that moved less keeps sign and limits")] = (
        0.3
    )
    margin_rad: Annotated[float, Meta(ge=0.0, le=0.3, description="how far within its ends its limits are")] = 0.03


class ZeroCommand(Struct, frozen=True, kw_only=True):
    """Begin: the arm is held at 0 now."""


class DoneCommand(Struct, frozen=True, kw_only=True):
    """Every joint was moved: store the learnt rows."""


class Swept(Struct, frozen=True, kw_only=True):
    """The range that a joint was moved from 0, in radians of its later row."""

    lower_rad: float
    upper_rad: float
    enough: bool


class CalibrationState(Struct, frozen=True, kw_only=True):
    """The progress of a calibration: while it is `running`, and the range that each joint was moved."""

    running: bool
    joints: dict[str, Swept] = {}
    reason: str = ""


KIND = Kind(
    name="arm_calibration",
    summary="learns where an arm's joints are at 0, which way they count and how far they turn",
    family="app",
    entry="lbr_so101.calibration.capability:Calibration",
    settings=CalibrationSettings,
    inputs={"servos": ServosState},
    outputs={"state": CalibrationState},
    commands={
        "zero": Command(ZeroCommand, role="admin"),
        "done": Command(DoneCommand, role="admin"),
        "stop": StopCommand,
    },
    replies=dict.fromkeys(("zero", "done", "stop"), CommandReply),
    rows=(Rows(Joint, where={"bus": "bus"}, learnt=True), MotionStep),
    words=(
        Word(
            "/calibrate/zero",
            "zero",
            "Calibrate the arm: it is held at 0 now, every joint in the middle, the gripper closed, without torque",
            role="admin",
        ),
        Word(
            "/calibrate/done",
            "done",
            "Every joint was moved to both ends, first the way it counts up: write that down; s leaves all as it was",
            role="admin",
        ),
    ),
)
