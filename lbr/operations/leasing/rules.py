"""What a command wants of a holding, and the links of the chain it passes that are about leases."""

from math import inf, isfinite
from typing import Literal

from msgspec.structs import replace

from lbr.messages.codes import Reason
from lbr.messages.leases import STOPPED_SINCE
from lbr.operations.leasing.lease import Ask, Hold, Holding, Insisting, M, offered, quoted, streams

Intent = Literal["stop", "renewal", "change", "offer", "begin"]
"""`begin` also confirms an offer."""
LONGEST_TTL_S = 1.0
STOP_CAME = Reason("stopped", "a stop came after this command")
NOT_KNOWN = "it is not known here; ask for a new one without quoting a lease"
INSISTING_S = 0.25
MOST_INSISTING = 64
EVERYBODY = ""
ASK_FIRST = Reason(
    "query_first",
    "a motion from another machine begins with a query: its answer has the lease that the command then quotes",
)
TWICE = Reason("repeated", "this command came twice, or after a newer one")


def intent(holding: Holding[M], ask: Ask) -> Intent:
    """Return what a command wants: standing still without a lease is a stop, by whomever."""
    if not ask.moves and not ask.lease:
        return "stop"
    if holding.hold is None or ask.lease != holding.hold.lease:
        return "offer" if ask.remote and offered(holding, ask.lease) is None else "begin"
    return "renewal" if ask.what == holding.hold.what else "change"


def form(holding: Holding[M], ask: Ask, now: float) -> Reason | None:
    """The life that is asked for is one, and the command has not lain about."""
    ttl_s = ask.ttl_s or 0.0
    if not (isfinite(ttl_s) and 0.0 <= ttl_s <= LONGEST_TTL_S):
        return Reason("bad_value", f"ttl_s {ttl_s:g} is outside 0 to {LONGEST_TTL_S:g}")
    if ask.ttl_s == 0.0:
        return Reason("bad_value", f"ttl_s 0 lets a lease lapse at once: leave it out, or give up to {LONGEST_TTL_S:g}")
    return not_fresh(holding, ask, now)


def holder(holding: Holding[M], ask: Ask, now: float) -> Reason | None:
    """One holder: a quoted lease must be the live one; without a lease nobody may hold it, or it is taken over."""
    hold, owner = holding.hold, quoted(holding, ask)
    if ask.lease and not (owner is not None and now < owner.expires):  # this way round, NaN means dead
        return dead(holding, ask.lease)
    if why := _not_own(owner, ask) or _waited(holding, ask):
        return why
    if hold is not None and owner is hold:
        return _order(holding, ask, hold)
    takes = ask.take_over or (owner is not None and owner.take_over)
    if hold is not None and (not takes or streams(hold, ask)):
        return _held(hold, ask)
    if not (holding.estop or dated(holding, ask) > holding.stopped):
        return STOP_CAME
    return None if dated(holding, ask) > holding.begun else TWICE


def at_rest(holding: Holding[M], ask: Ask, now: float, trouble: Reason | None = None) -> Reason | None:
    """Nothing but standing still while the emergency stop is latched, or what would move it is in `trouble`."""
    if not ask.moves:
        return None
    if holding.estop:
        return latched(holding)
    if trouble:
        return trouble
    how = insists(holding, ask.source, now)
    return Reason("rest_first", f"{how}: {holding.words.rest}") if how else None


def dead(holding: Holding[M], lease: str) -> Reason:
    """Return why a lease that is not live is refused, and how it ended."""
    ended = dict(holding.dead).get(lease)
    if ended is None:
        return Reason("dead_lease", f"lease is dead: {NOT_KNOWN}", note=NOT_KNOWN)
    return Reason("dead_lease", f"lease is dead: {ended}", cause=ended.code, note=ended.text)


def latched(holding: Holding[M]) -> Reason:
    """Return why nothing moves while the emergency stop is latched."""
    return Reason("estop", f"emergency stop: {holding.estop_reason or 'no reason given'}; 'reset' releases it")


def _not_own(owner: Hold[M] | None, ask: Ask) -> Reason | None:
    """A lease dates what its own sender says; another's clock proves nothing, nor does a lease that was overheard."""
    if owner is None or not (ask.remote and ask.source != owner.source and ask.moves):
        return None
    return Reason("foreign_lease", f"this lease is {owner.source}'s: ask for one of your own")


def _held(hold: Hold[M], ask: Ask) -> Reason:
    own = ", as you do: quote the lease to go on" if hold.source == ask.source else ""
    return Reason("held", f"held by {hold.source}{own}")


def _waited(holding: Holding[M], ask: Ask) -> Reason | None:
    """What was typed or written before another stopped the robot moves it no more, however late it is sent.

    How long it waited is told by its sender's clock alone, so that the clocks of two machines are never compared.
    """
    if holding.estop or not ask.moves or ask.waited_s == 0.0:
        return None
    at, by = holding.halts.by_others(ask.source)
    if dated(holding, ask) - ask.waited_s > at:  # this way round, NaN waited too long
        return None
    return Reason("stopped_since", f"{STOPPED_SINCE}{f'by {by}' if by else 'what moves it began anew'}")


def _order(holding: Holding[M], ask: Ask, hold: Hold[M]) -> Reason | None:
    """What quotes a lease counts once, and not after something newer; standing still counts whenever it comes."""
    if not ask.moves:
        return None
    newest = max(hold.said, hold.renewed)  # this way round, NaN is no renewal yet
    return None if dated(holding, ask) > newest else TWICE


def dated(holding: Holding[M], ask: Ask) -> float:
    """Return when a command was sent at the latest, on our clock.

    A remote sender's clock is read by the quickest message under the same lease: nothing sent later came sooner, so
    what a partition held back cannot pass for new when it heals.
    """
    behind_s = offset_s(ask, quoted(holding, ask))
    return ask.received if behind_s == inf else ask.sender_s + behind_s


def offset_s(ask: Ask, hold: Hold[M] | None) -> float:
    """Return how far the sender's clock is behind ours at most; infinite if that cannot be told."""
    if not (ask.remote and isfinite(ask.sender_s)):
        return inf
    seen_s = ask.received - ask.sender_s
    return seen_s if hold is None or hold.source != ask.source else min(seen_s, hold.offset_s)


def not_fresh(holding: Holding[M], ask: Ask, now: float) -> Reason | None:
    """Return why a command is too old to move anything, or nothing; standing still is never too old."""
    if not ask.moves:
        return None
    age_s = now - min(ask.received, dated(holding, ask))  # by rounding, a date may lie after the arrival
    if not age_s >= 0.0:
        return Reason("late", "this command has no date that makes sense")
    if not age_s <= ask.patience_s:
        return Reason("late", f"this command came {age_s:.1f} s after it was sent; send it again")
    return ASK_FIRST if ask.remote and not (ask.lease or ask.answerable) else None


def insists(holding: Holding[M], source: str, now: float) -> str:
    """Return how a source has been sending motion that it should not, until just now; or nothing."""
    found = holding.insisting.get(source) or holding.insisting.get(EVERYBODY)
    return "" if found is None or now >= found.until else found.how


def note_insisting(holding: Holding[M], source: str, how: str, now: float) -> Holding[M]:
    """Remember who goes on sending, so that the end of what stopped them by itself moves nothing."""
    recent = {name: found for name, found in holding.insisting.items() if not now >= found.until}
    known = source if source in recent or len(recent) < MOST_INSISTING else EVERYBODY
    return replace(holding, insisting={**recent, known: Insisting(until=now + INSISTING_S, how=how)})


def forget_insisting(holding: Holding[M], source: str) -> Holding[M]:
    """Take a source's word that it has come to rest."""
    if source not in holding.insisting:
        return holding
    return replace(holding, insisting={name: found for name, found in holding.insisting.items() if name != source})
