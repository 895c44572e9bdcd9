"""How a hold ends: by itself, by a stop, by a fault; and what is said of it."""

from math import isnan

from msgspec.structs import replace

from lbr.messages.motors import MotorSetpoint
from lbr.operations.drive import goals
from lbr.operations.drive.state import (
    TELLINGS,
    TELLINGS_PER_S,
    Ending,
    Goal,
    Happened,
    Hold,
    Level,
    Outputs,
    Result,
    Setpoint,
    State,
    Tally,
    bury,
    motors_trouble,
)
from lbr.operations.drive.wheels import next_wheels

Decision = tuple[State, Outputs]
ZERO = Setpoint(message=MotorSetpoint(left=0.0, right=0.0))
UNPLANNED = ("lapsed", "fault")


def end(state: State, how: Ending, why: str, now: float, *, heir: str = "") -> Decision:
    """Stand still at once; whoever held the base does so no more, and is told why. `heir` takes it over."""
    hold = state.hold
    still = next_wheels(replace(state, hold=None), now)
    if hold is None:
        return replace(still, reason=why), (ZERO,)
    level: Level = "warning" if how in UNPLANNED else "info"
    kind = "turned" if how == "reached" and hold.goal is not None and hold.goal.turn is not None else how
    said: Outputs = (ZERO, Happened(kind=kind, text=f"{hold.source}: {why}", level=level))
    if hold.goal is not None:
        said = (*said, result(hold.goal, how, why, now))
    state, told = (still, ()) if heir else tell_holder(still, now, lost=hold.source, why=why)
    return replace(bury(state, hold.lease, why), reason=why), said + told


def end_all(state: State, how: Ending, why: str, now: float) -> Decision:
    """End the hold and every offer: nothing that was asked for earlier may move the base afterwards."""
    state, ended = end(state, how, why, now)
    state, dropped = drop_offers(state, state.offers, how, why, now)
    return state, ended + dropped


def end_what_is_over(state: State, now: float) -> Decision:
    """End what is over by now; comparisons are such that NaN ends it."""
    said: Outputs = ()
    if state.offers:
        state, said = _end_offers(state, now)
    over = _what_is_over(state, now)
    if over is None:
        return state, said
    state, ended = end(state, *over, now)
    return state, said + ended


def drop_offers(state: State, offers: tuple[Hold, ...], how: Ending, why: str, now: float) -> Decision:
    """Take offers back."""
    said: Outputs = ()
    for offer in offers:
        state = bury(replace(state, offers=tuple(one for one in state.offers if one is not offer)), offer.lease, why)
        if offer.goal is not None:
            said = (*said, result(offer.goal, how, why, now))
    return state, said


def result(goal: Goal, how: Ending, why: str, now: float) -> Result:
    """Return how a bounded move ended."""
    return Result(message=goals.result(goal, how, why, now))


def tell_holder(state: State, now: float, *, took: str = "", lost: str = "", why: str = "") -> Decision:
    """Say who has the base from now on and who has not; in a flood of changes, how many were not said."""
    tally = state.tally
    refilled = tally.left + TELLINGS_PER_S * max(0.0, now - tally.at)  # this way round, NaN is no time
    left = min(TELLINGS, refilled)
    if left < 1.0:
        return replace(state, tally=Tally(left=left, at=now, untold=tally.untold + 1)), ()
    text = f"{lost} lost the base: {why}" if not took else f"{took} took the base" + (f" from {lost}" if lost else "")
    if tally.untold:
        text += f" (and {tally.untold} changes of holder before that)"
    data = {"took": took, "lost": lost, "why": why}
    told = Happened(kind="holder", text=text, data={name: said for name, said in data.items() if said})
    return replace(state, tally=Tally(left=left - 1.0, at=now)), (told,)


def _end_offers(state: State, now: float) -> Decision:
    if trouble := motors_trouble(state, now):
        return drop_offers(state, state.offers, "fault", trouble, now)
    lapsed = tuple(offer for offer in state.offers if not now < offer.expires)
    if not lapsed:
        return state, ()
    return drop_offers(state, lapsed, "lapsed", f"not confirmed within {lapsed[0].ttl_s:g} s", now)


def _what_is_over(state: State, now: float) -> tuple[Ending, str] | None:
    """Return how the hold ends by itself and why, or None while it lives."""
    hold = state.hold
    if hold is None:
        return None
    if trouble := motors_trouble(state, now):
        return "fault", trouble
    if not now < hold.expires:
        return "lapsed", f"it lapsed, not renewed within {hold.ttl_s:g} s"
    if hold.goal is not None and (ended := goals.ending(hold.goal, state.settings, now)):
        return ended
    worn = _worn_out(state, hold, now) if hold.power > 0.0 else ""
    return ("stopped", worn) if worn else None


def _worn_out(state: State, hold: Hold, now: float) -> str:
    """Return why a motion that nobody ended is over: it ran unattended, or a rule has held the base still."""
    settings = state.settings
    if not now - hold.changed < settings.max_run_s:
        return f"it ran for {settings.max_run_s:g} s unattended"
    if not isnan(state.blocked_since) and not now - state.blocked_since < settings.blocked_s:
        return f"held still for {settings.blocked_s:g} s: {state.limited.detail}"
    return ""
