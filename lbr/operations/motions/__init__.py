"""Motions: the named poses and motions of the rows, played through the joints; and poses captured by hand."""

from msgspec import Struct

from lbr.capability.kind import Command, Kind, names
from lbr.messages.drive import GoalResult
from lbr.messages.joints import (
    CaptureCommand,
    Joint,
    JointsCommand,
    JointsState,
    MotionRow,
    MotionsState,
    MotionStep,
    PlayCommand,
)
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.units import TtlS


class MotionsSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `motions` may set."""

    ttl_s: TtlS = 0.3


KIND = Kind(
    name="motions",
    summary="plays the motions of the rows, and writes down poses that were made by hand",
    family="operation",
    entry="lbr.operations.motions.capability:Motions",
    settings=MotionsSettings,
    inputs={"joints": JointsState, "ended": GoalResult},
    outputs={"state": MotionsState, "result": GoalResult},
    commands={
        "play": Command(PlayCommand, leased=True, choices={"motion": names(MotionRow)}),
        "capture": Command(CaptureCommand, choices={"motion": names(MotionRow)}),
        "stop": StopCommand,
    },
    replies=dict.fromkeys(("play", "capture", "stop", "move", "halt"), CommandReply),
    requests={"move": JointsCommand, "halt": StopCommand},
    roles={"capture": "admin"},
    moves=True,
    rows=(Joint, MotionRow, MotionStep),
    learns=(MotionRow, MotionStep),
)
