"""How a hold ends: by itself, by a stop, by a fault; and what is said of it."""

from msgspec.structs import replace

from lbr.capability.halts import Halts
from lbr.messages.codes import Reason
from lbr.operations.leasing.lease import (
    TELLINGS,
    TELLINGS_PER_S,
    Ended,
    Ending,
    Happened,
    Hold,
    Holding,
    Insisting,
    Level,
    M,
    Tally,
)
from lbr.operations.leasing.rules import INSISTING_S

Said = tuple[Ended[M] | Happened, ...]
Decision = tuple[Holding[M], Said[M]]

DEAD_LEASES_KEPT = 32
UNPLANNED = ("lapsed", "fault")


def end(holding: Holding[M], how: Ending, why: Reason, now: float, *, heir: str = "") -> Decision[M]:
    """End the hold, if there is one; its holder is told why. `heir` takes it over."""
    hold = holding.hold
    if hold is None:
        return replace(holding, reason=why), ()
    still = bury(replace(holding, hold=None, reason=why), hold.lease, why)
    ended = Ended(hold=hold, how=how, why=why)
    if heir:
        return still, (ended,)
    still, told = tell_holder(still, now, lost=hold.source, why=why)
    return still, (ended, *told)


def end_all(holding: Holding[M], how: Ending, why: Reason, now: float) -> Decision[M]:
    """End the hold and every offer: nothing that was asked for earlier may move anything afterwards."""
    holding, ended = end(holding, how, why, now)
    holding, dropped = drop_offers(holding, holding.offers, how, why)
    return holding, ended + dropped


def lapse(holding: Holding[M], now: float) -> Decision[M]:
    """End what was not quoted or renewed in time; comparisons are such that NaN ends it."""
    said: Said[M] = ()
    lapsed = tuple(offer for offer in holding.offers if not now < offer.expires)
    if lapsed:
        why = Reason("lapsed", f"not confirmed within {lapsed[0].ttl_s:g} s")
        holding, said = drop_offers(holding, lapsed, "lapsed", why)
    hold = holding.hold
    if hold is None or now < hold.expires:
        return holding, said
    why = Reason("lapsed", f"it lapsed, not renewed within {hold.ttl_s:g} s")
    holding, ended = end(holding, "lapsed", why, now)
    return holding, said + ended


def drop_offers(holding: Holding[M], offers: tuple[Hold[M], ...], how: Ending, why: Reason) -> Decision[M]:
    """Take offers back."""
    said: Said[M] = ()
    for offer in offers:
        left = tuple(one for one in holding.offers if one is not offer)
        holding = bury(replace(holding, offers=left), offer.lease, why)
        said = (*said, Ended(hold=offer, how=how, why=why, held=False))
    return holding, said


def lose_time(holding: Holding[M], why: Reason, clock: float, now: float) -> Decision[M]:
    """End everything and forget every date: none of it means anything on a clock that went back from `clock`."""
    recent = {name: found for name, found in holding.insisting.items() if not clock >= found.until}
    insisting = {name: Insisting(until=now + INSISTING_S, how=found.how) for name, found in recent.items()}
    forgotten = replace(holding, stopped=now, stopped_by="", begun=now, halts=Halts(at=now), insisting=insisting)
    return end_all(forgotten, "fault", why, now)


def happened(ended: Ended[M], kind: str = "") -> Happened:
    """Return how people are told that a hold ended; its kind is how it did, unless given."""
    level: Level = "warning" if ended.how in UNPLANNED else "info"
    return Happened(
        kind=kind or ended.how,
        text=f"{ended.hold.source}: {ended.why}",
        level=level,
        code=ended.why.code,
        about=ended.hold.source,
    )


def tell_holder(
    holding: Holding[M], now: float, *, took: str = "", lost: str = "", why: Reason | None = None
) -> Decision[M]:
    """Say who has it from now on and who has not; in a flood of changes, how many were not said."""
    tally, noun = holding.tally, holding.words.noun
    refilled = tally.left + TELLINGS_PER_S * max(0.0, now - tally.at)  # this way round, NaN is no time
    left = min(TELLINGS, refilled)
    if left < 1.0:
        return replace(holding, tally=Tally(left=left, at=now, untold=tally.untold + 1)), ()
    text = f"{lost} lost {noun}: {why}" if not took else f"{took} took {noun}" + (f" from {lost}" if lost else "")
    if tally.untold:
        text += f" (and {tally.untold} changes of holder before that)"
    data = {"took": took, "lost": lost, "why": str(why or "")}
    told = Happened(
        kind="holder",
        text=text,
        data={name: said for name, said in data.items() if said},
        code=why.code if why else "",
        about=lost or took,
    )
    return replace(holding, tally=Tally(left=left - 1.0, at=now)), (told,)


def bury(holding: Holding[M], lease: str, why: Reason) -> Holding[M]:
    """Return the holding with this lease dead for ever."""
    return replace(holding, dead=(*holding.dead, (lease, why))[-DEAD_LEASES_KEPT:])
