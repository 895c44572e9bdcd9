"""The data of lending motion: leases, requests, stops and replies."""

from collections.abc import Hashable, Mapping
from math import inf, nan
from typing import Generic, Literal, TypeVar

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
"""Changes of holder reported at once; more come back at `TELLINGS_PER_S`."""
TELLINGS_PER_S = 5.0

IDLE = Reason("idle", "")


class Phrasing(Struct, frozen=True, kw_only=True):
    """The terms in which a kernel speaks of what it moves: the base, send power 0."""

    noun: str
    rest: str
    idle: str


class LeaseRequest(Struct, frozen=True, kw_only=True):
    """A command as far as leases are concerned; it was sent, or else came in, at `received`.

    `content`: the command apart from sender, lease and lifetime; `moves` says that it is not standing still. `remote`:
    from another machine, whose clock said `sender_s` (NaN: it did not tell). `answerable`: the sender waits for the
    reply. `new_lease` is for what it may begin. It may be `patience_s` old. For `waited_s` before it was sent it had
    waited at its sender, as a line does that was typed ahead. `by` asked its sender for it, if anybody did.
    """

    source: str
    lease: str
    content: Hashable
    moves: bool
    received: float
    new_lease: str
    take_over: bool = False
    ttl_s: float | None = None
    remote: bool = False
    sender_s: float = nan
    answerable: bool = True
    patience_s: float = LATE_S
    waited_s: float = 0.0
    by: str = ""


class Stop(Struct, frozen=True, kw_only=True):
    """A sender wants it to stand still; `lost` says that the one who wanted the motion is gone, and counts from its
    holder.

    `whole`: the robot is to stand still, not only what its holder moves. `own`: its source gives up what it asked for
    itself. `by` is who said so, if its source passes it on; `at_once`: it does not step to its feet first.
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
    """The emergency stop was latched or reset, `by` whom."""

    engaged: bool
    reason: str = ""
    by: str = ""


class Lease(Struct, Generic[M], frozen=True, kw_only=True):
    """A live lease, what its holder asked for, and the motion that the kernel made of it.

    `asked_s` is when that was asked, `renewed` when the newest that quoted the lease was (NaN: none yet), `changed` when
    it was accepted. `offset_s` is the least that a remote sender's clock was seen to be behind ours.
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
    """A source that goes on sending motion when it should not; `how` describes that."""

    until: float
    how: str


class Tally(Struct, frozen=True, kw_only=True):
    """A budget for reports of a new holder: how many may be reported now, and how many were not."""

    budget: float = TELLINGS
    at: float = -inf
    untold: int = 0


class LeaseTable(Struct, Generic[M], frozen=True, kw_only=True):
    """Every lease on what moves. `offers` are leases that remote senders have yet to quote.

    Commands sent at or before `stopped` or `begun` begin nothing any more, nor those that had waited at their sender
    since before one of `halts`; `stopped_by` is the sender, if it was a stop. `reason` is why it has no holder. A lease
    lives for `ttl_s` if its ask says nothing, and is over up to `ahead_s` sooner, so that the motion is too.
    """

    phrasing: Phrasing
    ttl_s: float
    ahead_s: float = 0.0
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
    """A lease that is over, or an offer: those are not `held`, and moved nothing."""

    lease: Lease[M]
    how: Ending
    why: Reason
    held: bool = True


class Happened(Struct, frozen=True, kw_only=True):
    """An event for people; `code` is the reason, `about` the sender whose motion it concerns."""

    kind: str
    text: str
    level: Level = "info"
    data: Mapping[str, str] = {}
    code: str = ""
    about: str = ""


class Setpoint(Struct, frozen=True, kw_only=True):
    """A setpoint for what moves."""

    message: Struct


class Result(Struct, frozen=True, kw_only=True):
    """The result of a motion."""

    message: GoalResult


class Reply(Struct, frozen=True, kw_only=True):
    """The answer to the command or stop that was just decided."""

    message: CommandReply
    late: bool = False


def first(phrasing: Phrasing, ttl_s: float, ahead_s: float = 0.0, *, began: float = -inf) -> "LeaseTable[M]":
    """Return a table without a holder. Commands that were not sent after it `began` may have been stopped since, and
    begin nothing."""
    idle, halts = Reason("idle", phrasing.idle), Halts(at=began)
    return LeaseTable(phrasing=phrasing, ttl_s=ttl_s, ahead_s=ahead_s, stopped=began, halts=halts, reason=idle)
