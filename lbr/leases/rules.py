"""The intent of a command, and the links of the chain it passes that are about leases."""

from math import inf, isfinite
from typing import Literal

from msgspec.structs import replace

from lbr.leases.lease import Lease, LeaseRequest, LeaseTable, M, PersistentSender, offered, quoted, streams
from lbr.messages.codes import Reason
from lbr.messages.leases import STOPPED_SINCE

Intent = Literal["stop", "renewal", "change", "offer", "begin"]
"""`begin` also confirms an offer."""
LONGEST_TTL_S = 1.0
STOP_CAME = Reason("stopped", "a stop came after this command")
NOT_KNOWN = "it is not known here; ask for a new one without quoting a lease"
FORGOTTEN = "it is not known any more, as after a restart of what carries it out"
PERSISTENT_S = 0.25
MOST_PERSISTENT = 64
EVERYBODY = ""
ASK_FIRST = Reason(
    "query_first",
    "a motion from another machine begins with a query: its answer has the lease that the command then quotes",
)
TWICE = Reason("repeated", "this command came twice, or after a newer one")


def intent(leases: LeaseTable[M], ask: LeaseRequest) -> Intent:
    """Return what a command wants: standing still without a lease is a stop, by whomever."""
    if not ask.moves and not ask.lease:
        return "stop"
    if leases.live is None or ask.lease != leases.live.id:
        return "offer" if ask.remote and offered(leases, ask.lease) is None else "begin"
    return "renewal" if ask.what == leases.live.what else "change"


def form(leases: LeaseTable[M], ask: LeaseRequest, now: float) -> Reason | None:
    """The life that is asked for is one, and the command has not lain about."""
    ttl_s = ask.ttl_s or 0.0
    if not (isfinite(ttl_s) and 0.0 <= ttl_s <= LONGEST_TTL_S):
        return Reason("bad_value", f"ttl_s {ttl_s:g} is outside 0 to {LONGEST_TTL_S:g}")
    if ask.ttl_s == 0.0:
        return Reason("bad_value", f"ttl_s 0 lets a lease lapse at once: leave it out, or give up to {LONGEST_TTL_S:g}")
    return not_fresh(leases, ask, now)


def holder(leases: LeaseTable[M], ask: LeaseRequest, now: float) -> Reason | None:
    """One holder: a quoted lease must be the live one; without a lease it must be free, or is taken over."""
    lease, owner = leases.live, quoted(leases, ask)
    if ask.lease and not (owner is not None and now < owner.expires):  # this way round, NaN means dead
        return not_live(leases, ask.lease)
    if why := _not_own(owner, ask) or _waited(leases, ask):
        return why
    if lease is not None and owner is lease:
        return _order(leases, ask, lease)
    takes = ask.take_over or (owner is not None and owner.take_over)
    if lease is not None and (not takes or streams(lease, ask)):
        return _held(lease, ask)
    if not (leases.estop or dated(leases, ask) > leases.stopped):
        return STOP_CAME
    return None if dated(leases, ask) > leases.begun else TWICE


def at_rest(leases: LeaseTable[M], ask: LeaseRequest, now: float, trouble: Reason | None = None) -> Reason | None:
    """Nothing but standing still while the emergency stop is latched, or what would move it is in `trouble`."""
    if not ask.moves:
        return None
    if leases.estop:
        return latched(leases)
    if trouble:
        return trouble
    how = persists(leases, ask.source, now)
    return Reason("rest_first", f"{how}: {leases.phrasing.rest}") if how else None


def not_live(leases: LeaseTable[M], lease_id: str) -> Reason:
    """Return why a lease that is not live is refused, and how it ended."""
    ended = dict(leases.revoked).get(lease_id)
    if ended is None:
        return Reason("dead_lease", f"lease is dead: {NOT_KNOWN}", note=FORGOTTEN)
    return Reason("dead_lease", f"lease is dead: {ended}", cause=ended.code, note=ended.text)


def latched(leases: LeaseTable[M]) -> Reason:
    """Return why nothing moves while the emergency stop is latched."""
    return Reason("estop", f"emergency stop: {leases.estop_reason or 'no reason given'}; 'reset' releases it")


def _not_own(owner: Lease[M] | None, ask: LeaseRequest) -> Reason | None:
    """A lease dates what its own sender says; another's clock proves nothing, nor does a lease that was overheard."""
    if owner is None or not (ask.remote and ask.source != owner.source and ask.moves):
        return None
    return Reason("foreign_lease", f"this lease is {owner.source}'s: ask for one of your own")


def _held(lease: Lease[M], ask: LeaseRequest) -> Reason:
    own = lease.source == ask.source
    text = f"held by {lease.source}{', as you do: quote the lease to go on' if own else '; stop it first'}"
    return Reason("held", text, holder=lease.source)


def _waited(leases: LeaseTable[M], ask: LeaseRequest) -> Reason | None:
    """Refuse what was typed or written before another stopped the robot, however late it is sent.

    A sender's own stops are meant in their order, whoever passes them or its commands on. How long it waited is told by
    its sender's clock alone, so that the clocks of two machines are never compared.
    """
    if leases.estop or not ask.moves or ask.waited_s == 0.0:
        return None
    at, by = leases.halts.by_others(ask.by or ask.source)
    if dated(leases, ask) - ask.waited_s > at:  # this way round, NaN waited too long
        return None
    return Reason("stopped_since", f"{STOPPED_SINCE}{f'by {by}' if by else 'what moves it started over'}")


def _order(leases: LeaseTable[M], ask: LeaseRequest, lease: Lease[M]) -> Reason | None:
    """Refuse what quotes a lease a second time, or after something newer; standing still always counts."""
    if not ask.moves:
        return None
    newest = max(lease.said, lease.renewed)  # this way round, NaN is no renewal yet
    return None if dated(leases, ask) > newest else TWICE


def dated(leases: LeaseTable[M], ask: LeaseRequest) -> float:
    """Return when a command was sent at the latest, on our clock.

    A remote sender's clock is read by the quickest message under the same lease: nothing sent later came sooner, so
    what a partition held back cannot pass for new when it heals.
    """
    behind_s = offset_s(ask, quoted(leases, ask))
    return ask.received if behind_s == inf else ask.sender_s + behind_s


def offset_s(ask: LeaseRequest, lease: Lease[M] | None) -> float:
    """Return how far the sender's clock is behind ours at most; infinite if that cannot be told."""
    if not (ask.remote and isfinite(ask.sender_s)):
        return inf
    seen_s = ask.received - ask.sender_s
    return seen_s if lease is None or lease.source != ask.source else min(seen_s, lease.offset_s)


def not_fresh(leases: LeaseTable[M], ask: LeaseRequest, now: float) -> Reason | None:
    """Return why a command is too old to move anything, or nothing; standing still is never too old."""
    if not ask.moves:
        return None
    age_s = now - min(ask.received, dated(leases, ask))  # by rounding, a date may lie after the arrival
    if not age_s >= 0.0:
        return Reason("late", "this command has no date that makes sense")
    if not age_s <= ask.patience_s:
        return Reason("late", f"this command came {age_s:.1f} s after it was sent; send it again")
    return ASK_FIRST if ask.remote and not (ask.lease or ask.answerable) else None


def persists(leases: LeaseTable[M], source: str, now: float) -> str:
    """Return how a source has been sending motion that it should not, until just now; or nothing."""
    found = leases.persistent.get(source) or leases.persistent.get(EVERYBODY)
    return "" if found is None or now >= found.until else found.how


def note_persistent(leases: LeaseTable[M], source: str, how: str, now: float) -> LeaseTable[M]:
    """Remember who goes on sending, so that the end of what stopped them by itself moves nothing."""
    recent = {name: found for name, found in leases.persistent.items() if not now >= found.until}
    known = source if source in recent or len(recent) < MOST_PERSISTENT else EVERYBODY
    return replace(leases, persistent={**recent, known: PersistentSender(until=now + PERSISTENT_S, how=how)})


def forget_persistent(leases: LeaseTable[M], source: str) -> LeaseTable[M]:
    """Take a source's word that it has come to rest."""
    if source not in leases.persistent:
        return leases
    return replace(leases, persistent={name: found for name, found in leases.persistent.items() if name != source})
