"""The data of lending motion: leases, requests, stops and replies."""

from collections.abc import Hashable, Mapping
from math import inf, nan
from typing import Any, Generic, Literal, TypeVar

from msgspec import Struct

from lbr.leases.halts import Halts
from lbr.messages.codes import Reason
from lbr.messages.drive import GoalResult
from lbr.messages.leases import CommandReply

M = TypeVar("M")
Ending = Literal["reached", "interval", "stopped", "lapsed", "superseded", "fault"]
Level = Literal["info", "warning", "error"]

LATE_S = 0.3
TELLINGS = 20
"""Changes of holder reported at once; more are allowed later, at `TELLINGS_PER_S`."""
TELLINGS_PER_S = 5.0

IDLE = Reason("idle", "")


class Phrasing(Struct, frozen=True, kw_only=True):
    """A kernel's terms for its motion, such as `the base` and `send power 0`."""

    noun: str
    rest: str
    idle: str


class Origin(Struct, frozen=True, kw_only=True):
    """The sender of a command; it was sent, otherwise it arrived, at `received`.

    `remote`: from another machine, whose clock showed `sender_s` (NaN: unknown). `answerable`: the sender waits for the
    reply. `new_lease` is the id for a new lease. It had waited at its sender for `waited_s`, as a line does that was
    typed ahead. `by` is the original sender, if there is one.
    """

    source: str
    received: float
    new_lease: str
    remote: bool = False
    sender_s: float = nan
    waited_s: float = 0.0
    by: str = ""
    answerable: bool = True

    def origin(self) -> dict[str, Any]:
        """Return these fields, for another struct with them."""
        return {name: getattr(self, name) for name in Origin.__struct_fields__}


class LeaseRequest(Origin, frozen=True, kw_only=True):
    """A command for the rules of leases. It may be `patience_s` old.

    `content` is the command without sender, lease and lifetime; `moves`: it asks for motion.
    """

    lease: str
    content: Hashable
    moves: bool
    take_over: bool = False
    ttl_s: float | None = None
    patience_s: float = LATE_S


class Stop(Struct, frozen=True, kw_only=True):
    """A stop; `lost`: the user of the motion is gone, which counts only from the holder.

    `whole`: the whole robot stops, not only the holder's motion. `own`: its source gives up its own request. `by` is
    the original sender, if its source passes it on. `at_once`: the robot does not step to its feet first.
    """

    source: str
    received: float
    reason: str = ""
    lost: bool = False
    whole: bool = False
    own: bool = False
    by: str = ""
    at_once: bool = False


class EstopChanged(Struct, frozen=True, kw_only=True):
    """The emergency stop was latched or reset, by the sender `by`."""

    engaged: bool
    reason: str = ""
    by: str = ""


class Lease(Struct, Generic[M], frozen=True, kw_only=True):
    """A live lease, its holder's request, and the kernel's motion for it.

    `asked_s` is the time of the request, `renewed` that of the newest message with the lease (NaN: none yet), `changed`
    that of the acceptance. `offset_s` is the smallest delay of a remote sender's clock against ours.
    """

    id: str
    source: str
    content: Hashable
    motion: M
    ttl_s: float
    changed: float
    asked_s: float
    expires: float = nan
    renewed: float = nan
    offset_s: float = inf
    take_over: bool = False


class PersistentSender(Struct, frozen=True, kw_only=True):
    """A source that goes on sending motion without permission; `how` describes that."""

    until: float
    how: str


class Tally(Struct, frozen=True, kw_only=True):
    """A budget for reports of new holders: the number that may be reported now, and of those that were not."""

    budget: float = TELLINGS
    at: float = -inf
    untold: int = 0


class LeaseTable(Struct, Generic[M], frozen=True, kw_only=True):
    """All leases on a mover. `offers` are leases that remote senders have yet to quote.

    Commands sent at or before `stopped` or `begun` begin nothing any more. The same holds for those that have waited at
    their sender since before one of `halts`. `stopped_by` is the sender, if it was a stop. `reason` is why there is no
    holder. A lease lives for `ttl_s` by default, and ends up to `ahead_s` sooner, so that the motion has ended by then.
    """

    phrasing: Phrasing
    ttl_s: float
    ahead_s: float
    live: Lease[M] | None = None
    offers: tuple[Lease[M], ...] = ()
    revoked: tuple[tuple[str, Reason], ...] = ()
    stopped: float = -inf
    stopped_by: str = ""
    begun: float = -inf
    halts: Halts = Halts()
    estop: bool = False
    estop_reason: str = ""
    persistent: Mapping[str, PersistentSender] = {}
    tally: Tally = Tally()
    reason: Reason = IDLE


class Ended(Struct, Generic[M], frozen=True, kw_only=True):
    """A lease or offer that is over; an offer is not `held`, and moved nothing."""

    lease: Lease[M]
    how: Ending
    why: Reason
    held: bool = True


class Happened(Struct, frozen=True, kw_only=True):
    """An event for people; `code` is the reason, `about` the sender of the motion."""

    kind: str
    text: str
    level: Level = "info"
    data: Mapping[str, str] = {}
    code: str = ""
    about: str = ""


class Setpoint(Struct, frozen=True, kw_only=True):
    """A setpoint for a mover."""

    message: Struct


class Result(Struct, frozen=True, kw_only=True):
    """The result of a motion."""

    message: GoalResult


class Reply(Struct, frozen=True, kw_only=True):
    """The answer to the command or stop that was just decided."""

    message: CommandReply
    late: bool = False


def first(phrasing: Phrasing, ttl_s: float, ahead_s: float = 0.0, *, began: float = -inf) -> "LeaseTable[M]":
    """Return a table without a holder. Commands sent before it `began` may have been stopped since, and begin
    nothing."""
    idle, halts = Reason("idle", phrasing.idle), Halts(at=began)
    return LeaseTable(phrasing=phrasing, ttl_s=ttl_s, ahead_s=ahead_s, stopped=began, halts=halts, reason=idle)
