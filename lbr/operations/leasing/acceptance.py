"""What a command wants of a holding, and the links of the chain it passes that are about leases."""

from math import isfinite
from typing import Literal

from lbr.messages.leases import DEAD_LEASE, STOPPED_SINCE
from lbr.operations.leasing.freshness import TWICE, dated, insists, not_fresh
from lbr.operations.leasing.state import Ask, Hold, Holding, M, offered, quoted, streams

Intent = Literal["stop", "new", "confirmation", "renewal", "change"]
LONGEST_TTL_S = 1.0
NOT_KNOWN = "it is not known here; ask for a new one without quoting a lease"


def intent(holding: Holding[M], ask: Ask) -> Intent:
    """Return what a command wants: standing still without a lease is a stop, by whomever."""
    if not ask.moves and not ask.lease:
        return "stop"
    if holding.hold is None or ask.lease != holding.hold.lease:
        return "new" if offered(holding, ask.lease) is None else "confirmation"
    return "renewal" if ask.what == holding.hold.what else "change"


def form(holding: Holding[M], ask: Ask, now: float) -> str:
    """The life that is asked for is one, and the command has not lain about."""
    ttl_s = ask.ttl_s or 0.0
    if not (isfinite(ttl_s) and 0.0 <= ttl_s <= LONGEST_TTL_S):
        return f"ttl_s {ttl_s:g} is outside 0 to {LONGEST_TTL_S:g}"
    if ask.ttl_s == 0.0:
        return f"ttl_s 0 is no life; leave it out or give up to {LONGEST_TTL_S:g}"
    return not_fresh(holding, ask, now)


def holder(holding: Holding[M], ask: Ask, now: float) -> str:
    """One holder: a quoted lease must be the live one; without a lease nobody may hold it, or it is taken over."""
    hold, owner = holding.hold, quoted(holding, ask)
    if ask.lease and not (owner is not None and now < owner.expires):  # this way round, NaN means dead
        return f"{DEAD_LEASE}{why_dead(holding, ask.lease)}"
    if why := _not_own(owner, ask) or _waited(holding, ask):
        return why
    if hold is not None and owner is hold:
        return _order(holding, ask, hold)
    takes = ask.take_over or (owner is not None and owner.take_over)
    if hold is not None and (not takes or streams(hold, ask)):
        return _held(hold, ask)
    if not (holding.estop or dated(holding, ask) > holding.stopped):
        return "a stop came after this command"
    return "" if dated(holding, ask) > holding.begun else TWICE


def at_rest(holding: Holding[M], ask: Ask, now: float, trouble: str = "") -> str:
    """Nothing but standing still while the emergency stop is latched, or what would move it is in `trouble`."""
    if not ask.moves:
        return ""
    if holding.estop:
        return f"emergency stop: {holding.estop_reason or 'no reason given'}; 'reset' releases it"
    if trouble:
        return trouble
    how = insists(holding, ask.source, now)
    return f"{how}: {holding.words.rest}" if how else ""


def why_dead(holding: Holding[M], lease: str) -> str:
    """Return why a lease that is not live died."""
    return dict(holding.dead).get(lease, NOT_KNOWN)


def _not_own(owner: Hold[M] | None, ask: Ask) -> str:
    """A lease dates what its own sender says; another's clock proves nothing, nor does a lease that was overheard."""
    if owner is None or not (ask.remote and ask.source != owner.source and ask.moves):
        return ""
    return f"this lease is {owner.source}'s: ask for one of your own"


def _held(hold: Hold[M], ask: Ask) -> str:
    own = ", as you do: quote the lease to go on" if hold.source == ask.source else ""
    return f"held by {hold.source}{own}"


def _waited(holding: Holding[M], ask: Ask) -> str:
    """What somebody typed or wrote before another stopped the robot moves it no more, however late it is sent.

    How long it waited is told by its sender's clock alone, so that the clocks of two machines are never compared.
    """
    if holding.estop or not ask.moves or ask.waited_s == 0.0:
        return ""
    at, by = holding.halts.by_others(ask.source)
    if dated(holding, ask) - ask.waited_s > at:  # this way round, NaN waited too long
        return ""
    return f"{STOPPED_SINCE}{f'by {by}' if by else 'what moves it began anew'}"


def _order(holding: Holding[M], ask: Ask, hold: Hold[M]) -> str:
    """What quotes a lease counts once, and not after something newer; standing still counts whenever it comes."""
    if not ask.moves:
        return ""
    newest = max(hold.said, hold.renewed)  # this way round, NaN is no renewal yet
    return "" if dated(holding, ask) > newest else TWICE
