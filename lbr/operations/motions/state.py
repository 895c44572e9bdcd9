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
    """A sender wants a motion to be played, or renews that; without a programme it cannot be, for this reason.

    `trouble` is why joints operation would not follow, or nothing.
    """

    ask: LeaseRequest
    programme: Programme | None
    new_goal: str
    reason: Reason | None = None
    trouble: Reason | None = None


class Accepted(Struct, frozen=True, kw_only=True):
    """Joints operation follows: its own goal, and what it has to say."""

    goal: str
    note: Reason | None = None


class Lost(Struct, frozen=True, kw_only=True):
    """Joints operation does not follow, or not any more."""

    why: Reason


class JointsEnded(Struct, frozen=True, kw_only=True):
    """A goal of joints operation ended."""

    result: GoalResult


class JointsStopped(Struct, frozen=True, kw_only=True):
    """The joints themselves were stopped: what was asked for by `at` does not begin."""

    at: float
    why: Reason


class Passed(Struct, frozen=True, kw_only=True):
    """The number of key frames of a goal of joints operation that lie behind."""

    goal: str
    frames: int


class Fell(Struct, frozen=True, kw_only=True):
    """The robot has fallen."""

    how: str


class Tick(Struct, frozen=True, kw_only=True):
    """Time goes by."""


Event = Play | Stop | EstopChanged | Accepted | Lost | JointsEnded | JointsStopped | Passed | Fell | Tick


class Answer(Struct, frozen=True, kw_only=True):
    """The answer to the sender that waits for a motion to begin."""

    message: CommandReply


class Send(Struct, frozen=True, kw_only=True):
    """Key frames for the joints: instead of what they do, or after it. The sender waits for their answer.

    `asked_s` is when that was; what is appended bears none. `stored` is for their controller, instead of key frames.
    `leg`: they came to rest in the middle of what is played, and no sender waits for the answer.
    """

    frames: tuple[KeyFrame, ...]
    append: bool
    stored: StoredMotion | None = None
    leg: bool = False
    mirror: bool
    asked_s: float | None = None
    take_over: bool = False


class Halt(Struct, frozen=True, kw_only=True):
    """The joints are to be stopped; `lost`: the sender that had it played is gone; `by`: who said so; `at_once`: they
    do not step to their feet."""

    why: str
    lost: bool = False
    by: str = ""
    at_once: bool = False


class Abandon(Struct, frozen=True):
    """The joints hold by themselves: they came to the end, or have another holder."""


Output = Reply | Answer | Send | Halt | Abandon | Result | Happened
Outputs = tuple[Output, ...]


class Playing(Struct, frozen=True, kw_only=True):
    """A motion under way: `sent` of its steps were sent, `passed` lie behind; the joints began from rest with step
    `leg`.

    `asked`: joints operation has not answered yet; `joints_goal` is its name for it. `lost` is why its lease is no
    more, since `lost_at`.
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
    """Everything the kernel remembers; `clock` is the time of the last event."""

    leases: LeaseTable[Playing]
    clock: float = -inf

    @property
    def lease(self) -> Lease[Playing] | None:
        """Return the player and its motion."""
        return self.leases.live


def first_state(ttl_s: float, began: float = -inf) -> State:
    """Return that nothing is played since it `began`."""
    return State(leases=first(PHRASING, ttl_s, began=began))
