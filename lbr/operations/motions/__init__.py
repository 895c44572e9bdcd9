"""Motions: the named poses and motions of the rows, played through the joints; and poses captured by hand."""

from msgspec import Struct

from lbr.capability.kind import Command, Kind, Rows, names
from lbr.capability.word import Word
from lbr.messages.attitude import AttitudeState
from lbr.messages.drive import GoalResult
from lbr.messages.joints import (
    BusOfJoints,
    CaptureCommand,
    Joint,
    JointsCommand,
    JointsState,
    MotionRow,
    MotionsState,
    MotionStep,
    PlayCommand,
)
from lbr.messages.leases import StopCommand
from lbr.messages.units import TtlS


class MotionsSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `motions`."""

    ttl_s: TtlS = 0.3
    bus: BusOfJoints = ""


KIND = Kind(
    name="motions",
    summary="plays the motions of the rows, and writes down poses that were made by hand",
    family="operation",
    entry="lbr.operations.motions.capability:Motions",
    settings=MotionsSettings,
    inputs={"joints": JointsState, "ended": GoalResult, "attitude": AttitudeState},
    optional=("attitude",),
    outputs={"state": MotionsState, "result": GoalResult},
    commands={
        "play": Command(PlayCommand, leased=True, choices={"motion": names(MotionRow)}),
        "capture": Command(CaptureCommand, choices={"motion": names(MotionRow)}, role="admin"),
        "stop": StopCommand,
    },
    requests={"move": JointsCommand, "halt": StopCommand},
    moves=True,
    rows=(Rows(Joint, where={"bus": "bus"}), Rows(MotionRow, learnt=True), Rows(MotionStep, learnt=True)),
    words=(
        Word("/play/{motion}", "play", "Play a motion once, by its name"),
        Word("/play/{motion}/{times}", "play", "Play a motion this many times, 1 to 1000; s ends it"),
        Word(
            "/play/{motion}/{times}/{speed}",
            "play",
            "The same faster or slower, 0.1 to 3 times as its rows say; what a controller keeps has one speed",
        ),
        Word(
            "/mirror/{motion}",
            "play",
            "Play a motion with left and right exchanged; not what a controller keeps",
            {"mirror": True},
        ),
        Word(
            "/mirror/{motion}/{times}",
            "play",
            "Play a motion with left and right exchanged, this many times",
            {"mirror": True},
        ),
        Word("/pose/{motion}", "play", "Take a pose: a motion of one key frame", {"times": 1}),
        Word("/capture/{motion}", "capture", "Append the joints' pose to a motion, or begin a new one with it"),
        Word(
            "/capture/{motion}/{duration_s}",
            "capture",
            "The same, to be reached this many seconds after the frame before",
        ),
    ),
)
