"""The end of a lease: by itself, by a stop, by a fault; and the messages about it."""

from msgspec.structs import replace

from lbr.leases.halts import Halts
from lbr.leases.lease import (
    TELLINGS,
    TELLINGS_PER_S,
    Ended,
    Ending,
    Happened,
    Lease,
    LeaseTable,
    Level,
    M,
    PersistentSender,
    Tally,
)
from lbr.leases.rules import PERSISTENT_S
from lbr.messages.codes import Reason

Endings = tuple[Ended[M] | Happened, ...]
Decision = tuple[LeaseTable[M], Endings[M]]

REVOKED_KEPT = 32
UNPLANNED = ("lapsed", "fault")
BACK = Reason("clock", "the clock went back")


def end(leases: LeaseTable[M], how: Ending, why: Reason, now: float, *, heir: str = "") -> Decision[M]:
    """End the lease, if there is one, and report the reason to its holder. `heir` is the next holder."""
    lease = leases.live
    if lease is None:
        return replace(leases, reason=why), ()
    still = revoke(replace(leases, live=None, reason=why), lease.id, why)
    ended = Ended(lease=lease, how=how, why=why)
    if heir:
        return still, (ended,)
    still, told = report_holder(still, now, lost=lease.source, why=why)
    return still, (ended, *told)


def end_all(leases: LeaseTable[M], how: Ending, why: Reason, now: float) -> Decision[M]:
    """End the lease and every offer: no earlier request may move anything afterwards."""
    leases, ended = end(leases, how, why, now)
    leases, dropped = drop_offers(leases, leases.offers, how, why)
    return leases, ended + dropped


def lapse(leases: LeaseTable[M], now: float) -> Decision[M]:
    """End leases and offers that were not renewed or quoted in time; the comparisons end them on NaN."""
    messages: Endings[M] = ()
    lapsed = tuple(offer for offer in leases.offers if not now < offer.expires)
    if lapsed:
        why = Reason("lapsed", f"not confirmed within {lapsed[0].ttl_s:g} s")
        leases, messages = drop_offers(leases, lapsed, "lapsed", why)
    lease = leases.live
    if lease is None or now < lease.expires:
        return leases, messages
    why = Reason("lapsed", f"it lapsed, not renewed within {lease.ttl_s:g} s")
    leases, ended = end(leases, "lapsed", why, now)
    return leases, messages + ended


def drop_offers(leases: LeaseTable[M], offers: tuple[Lease[M], ...], how: Ending, why: Reason) -> Decision[M]:
    """Withdraw offers."""
    messages: Endings[M] = ()
    for offer in offers:
        offered = tuple(one for one in leases.offers if one is not offer)
        leases = revoke(replace(leases, offers=offered), offer.id, why)
        messages = (*messages, Ended(lease=offer, how=how, why=why, held=False))
    return leases, messages


def lose_time(leases: LeaseTable[M], clock: float, now: float) -> Decision[M]:
    """End everything and forget every date: they have no meaning on a clock that went back from `clock`."""
    recent = {name: found for name, found in leases.persistent.items() if not clock >= found.until}
    persistent = {name: PersistentSender(until=now + PERSISTENT_S, how=found.how) for name, found in recent.items()}
    forgotten = replace(leases, stopped=now, stopped_by="", begun=now, halts=Halts(at=now), persistent=persistent)
    return end_all(forgotten, "fault", BACK, now)


def happened(ended: Ended[M], kind: str = "") -> Happened:
    """Return the event for people about the end of a lease; its kind is the ending, unless given."""
    level: Level = "warning" if ended.how in UNPLANNED else "info"
    source, why = ended.lease.source, ended.why
    return Happened(kind=kind or ended.how, text=f"{source}: {why}", level=level, code=why.code, about=source)


def report_holder(
    leases: LeaseTable[M], now: float, *, took: str = "", lost: str = "", why: Reason | None = None
) -> Decision[M]:
    """Report the new holder and the previous one; in a flood of changes, the number of unreported ones."""
    tally, noun = leases.tally, leases.phrasing.noun
    refilled = tally.budget + TELLINGS_PER_S * max(0.0, now - tally.at)  # this way round, NaN counts as no time
    budget = min(TELLINGS, refilled)
    if budget < 1.0:
        return replace(leases, tally=Tally(budget=budget, at=now, untold=tally.untold + 1)), ()
    text = f"{lost} lost {noun}: {why}" if not took else f"{took} took {noun}" + (f" from {lost}" if lost else "")
    if tally.untold:
        text += f" (and {tally.untold} changes of holder before that)"
    known = {"took": took, "lost": lost, "why": str(why or "")}
    data, code = {name: value for name, value in known.items() if value}, why.code if why else ""
    change = Happened(kind="holder", text=text, data=data, code=code, about=lost or took)
    return replace(leases, tally=Tally(budget=budget - 1.0, at=now)), (change,)


def revoke(leases: LeaseTable[M], lease_id: str, why: Reason) -> LeaseTable[M]:
    """Return the leases with this one revoked for ever."""
    return replace(leases, revoked=(*leases.revoked, (lease_id, why))[-REVOKED_KEPT:])
