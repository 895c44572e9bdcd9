"""Teleoperation: an arm follows another one that a hand moves, under a lease like any other motion."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, Rows
from lbr.capability.word import Word
from lbr.messages.codes import ReasonCode
from lbr.messages.drive import LoopStatistics
from lbr.messages.joints import BusOfJoints, Joint, JointsCommand, JointsState
from lbr.messages.leases import CommandReply, StopCommand

Phase = Literal["idle", "approaching", "following"]


class TeleopSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of a row of kind `teleop`. A joint of the leader has the follower's name after `leader`."""

    leader: Annotated[str, Meta(pattern="^[a-z][a-z0-9_]*$", max_length=30)] = "leader_"
    bus: BusOfJoints = ""
    near_rad: Annotated[float, Meta(gt=0.0, le=1.0, description="so near it follows, further away it approaches")] = 0.2
    far_rad: Annotated[float, Meta(gt=0.0, le=3.0, description="once it follows: so far away it approaches again")] = (
        1.0
    )
    approach_rps: Annotated[float, Meta(gt=0.0, le=5.0, description="how fast it approaches, radians a second")] = 0.4
    max_age_s: Annotated[float, Meta(ge=0.05, le=1.0, description="an older reading of the leader ends it")] = 0.2


class TeleopCommand(Struct, frozen=True, kw_only=True):
    """Have the follower follow the leader, until a stop; slowly at first."""


class TeleopState(Struct, frozen=True, kw_only=True):
    """The phase, the gap of the worst joint, the regularity of commands, and the reason of the last end."""

    phase: Phase
    gap_rad: float | None = None
    sent: int = 0
    loop: LoopStatistics | None = None
    reason: str = ""
    code: ReasonCode = ""


KIND = Kind(
    name="teleop",
    summary="has an arm go where another is moved by hand",
    family="app",
    entry="lbr_so101.teleop.capability:Teleop",
    settings=TeleopSettings,
    inputs={"leader": JointsState, "follower": JointsState},
    outputs={"state": TeleopState},
    commands={"begin": TeleopCommand, "stop": StopCommand},
    requests={"move": JointsCommand, "halt": StopCommand},
    replies=dict.fromkeys(("begin", "stop", "move", "halt"), CommandReply),
    rows=(Rows(Joint, where={"bus": "bus"}),),
    words=(Word("teleop", "begin", "Have the follower go where the leader is, slowly at first; s ends it"),),
)
