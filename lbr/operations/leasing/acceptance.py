"""What a command wants of a holding, and the links of the chain it passes that are about leases."""

from math import isfinite
from typing import Literal

from lbr.messages.codes import Reason
from lbr.messages.leases import STOPPED_SINCE
from lbr.operations.leasing.freshness import TWICE, dated, insists, not_fresh
from lbr.operations.leasing.state import Ask, Hold, Holding, M, offered, quoted, streams

Intent = Literal["stop", "new", "confirmation", "renewal", "change"]
LONGEST_TTL_S = 1.0
STOP_CAME = Reason("stopped", "a stop came after this command")
NOT_KNOWN = "it is not known here; ask for a new one without quoting a lease"


def intent(holding: Holding[M], ask: Ask) -> Intent:
    """Return what a command wants: standing still without a lease is a stop, by whomever."""
    if not ask.moves and not ask.lease:
        return "stop"
    if holding.hold is None or ask.lease != holding.hold.lease:
        return "new" if offered(holding, ask.lease) is None else "confirmation"
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
