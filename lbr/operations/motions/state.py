"""State, events and outputs of the kernel of motions."""

from math import inf

from msgspec import Struct

from lbr.leases.lease import (
    EstopChanged,
    Happened,
    Lease,
    LeaseRequest,
    LeaseTable,
    Phrasing,
    Reply,
    Result,
    Stop,
    first,
)
from lbr.messages.codes import Reason
from lbr.messages.drive import GoalResult
from lbr.messages.joints import KeyFrame, StoredMotion
from lbr.messages.leases import CommandReply
from lbr.operations.motions.programme import Programme

PHRASING = Phrasing(noun="the motions", rest="stop, or pause, before playing again", idle="nothing was played yet")


class Play(Struct, frozen=True, kw_only=True):
    """A sender's request to play a motion, or to renew it; without a programme it is refused, for `reason`.

    `trouble` is the reason why joints operation would not follow, or None.
    """

    ask: LeaseRequest
    programme: Programme | None
    new_goal: str
    reason: Reason | None = None
    trouble: Reason | None = None


class Accepted(Struct, frozen=True, kw_only=True):
    """Joints operation follows: its own goal, and its note."""

    goal: str
    note: Reason | None = None


class Lost(Struct, frozen=True, kw_only=True):
    """Joints operation does not follow, or no longer."""

    why: Reason


class JointsEnded(Struct, frozen=True, kw_only=True):
    """A goal of joints operation ended."""

    result: GoalResult


class JointsStopped(Struct, frozen=True, kw_only=True):
    """The joints themselves were stopped: motions requested by `at` do not begin."""

    at: float
    why: Reason


class Passed(Struct, frozen=True, kw_only=True):
    """The number of passed key frames of a goal of joints operation."""

    goal: str
    frames: int


class Fell(Struct, frozen=True, kw_only=True):
    """The robot has fallen."""

    how: str


class Tick(Struct, frozen=True, kw_only=True):
    """The time of a round."""


Event = Play | Stop | EstopChanged | Accepted | Lost | JointsEnded | JointsStopped | Passed | Fell | Tick


class Answer(Struct, frozen=True, kw_only=True):
    """The reply to the sender that waits for a motion to begin."""

    message: CommandReply


class Send(Struct, frozen=True, kw_only=True):
    """Key frames for the joints, in place of their motion, or after it. The sender waits for their reply.

    `asked_s` is the time of the request; appended frames have none. `stored` is for their controller, instead of key
    frames. `leg`: the joints came to rest in the middle of the play, and no sender waits for the reply.
    """

    frames: tuple[KeyFrame, ...]
    append: bool
    stored: StoredMotion | None = None
    leg: bool = False
    mirror: bool
    asked_s: float | None = None
    take_over: bool = False


class Halt(Struct, frozen=True, kw_only=True):
    """A stop of the joints. `lost`: the motion's sender is gone. `by`: the sender of the stop. `at_once`: without a
    step."""

    why: str
    lost: bool = False
    by: str = ""
    at_once: bool = False


class Abandon(Struct, frozen=True):
    """The joints hold by themselves: they came to the end, or have another holder."""


Output = Reply | Answer | Send | Halt | Abandon | Result | Happened
Outputs = tuple[Output, ...]


class Playing(Struct, frozen=True, kw_only=True):
    """A current motion: `sent` of its steps were sent, `passed` lie behind; from rest the joints began with step `leg`.

    `asked`: joints operation has not replied yet; `joints_goal` is its name for it. `lost` is the reason for the lost
    lease, since `lost_at`.
    """

    goal: str
    programme: Programme
    started: float
    asked: bool = True
    joints_goal: str = ""
    leg: int = 0
    sent: int = 0
    passed: int = 0
    lost: Reason | None = None
    lost_at: float = inf


class State(Struct, frozen=True, kw_only=True):
    """The whole state of the kernel; `clock` is the time of the last event."""

    leases: LeaseTable[Playing]
    clock: float = -inf

    @property
    def lease(self) -> Lease[Playing] | None:
        """Return the player and its motion."""
        return self.leases.live


def first_state(ttl_s: float, began: float = -inf) -> State:
    """Return the state with nothing played since it `began`."""
    return State(leases=first(PHRASING, ttl_s, began=began))
