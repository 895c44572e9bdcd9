"""The end of a motion of the base, by itself, by a stop or by a fault, and the messages about it."""

from math import isnan

from msgspec.structs import replace

from lbr.leases import ending
from lbr.leases.lease import Ended, Ending, Happened, Lease, LeaseTable, Result, Setpoint
from lbr.messages.codes import Reason
from lbr.messages.motors import MotorSetpoint
from lbr.operations.drive import goals
from lbr.operations.drive.state import ActiveMotion, Outputs, State, motors_trouble
from lbr.operations.drive.wheels import next_wheels

Decision = tuple[State, Outputs]
ZERO = Setpoint(message=MotorSetpoint(left=0.0, right=0.0, moving_s=0.0))
"""Zero for any base: it names no motor, and all of them stand still."""


def end_what_is_over(state: State, now: float) -> Decision:
    """End the motion if it is over at this time; with NaN in a comparison it is over."""
    held = state.leases
    if trouble := motors_trouble(state, now):
        held, said = ending.drop_offers(held, held.offers, "fault", trouble)
    else:
        held, said = ending.lapse(held, now)
    state, ended = apply(state, held, said, now)
    over = _what_is_over(state, trouble, now)
    if over is None:
        return state, ended
    state, more = apply(state, *ending.end(state.leases, *over, now), now)
    return state, ended + more


def halt(state: State, decided: ending.Decision[ActiveMotion], now: float) -> Decision:
    """Apply the decision on the holder of the base, and stop, whether it was held or not."""
    state, outputs = apply(state, *decided, now)
    return next_wheels(state, now), (ZERO, *outputs)


def apply(state: State, held: LeaseTable[ActiveMotion], said: ending.Endings[ActiveMotion], now: float) -> Decision:
    """Apply a decision on the leases, stop when the live lease is over, and return the result of each goal."""
    outputs: Outputs = ()
    for each in said:
        if isinstance(each, Happened):
            outputs = (*outputs, each)
            continue
        if each.held:
            state = next_wheels(replace(state, leases=replace(state.leases, live=None)), now)
            outputs = (*outputs, ZERO, ending.happened(each, _kind(each)))
        outputs = outputs + _result(each, now)
    return replace(state, leases=held), outputs


def _result(ended: Ended[ActiveMotion], now: float) -> Outputs:
    """Return the result of a bounded move, or nothing."""
    goal = ended.lease.motion.goal
    return () if goal is None else (Result(message=goals.result(goal, ended.how, ended.why, now)),)


def _kind(ended: Ended[ActiveMotion]) -> str:
    goal = ended.lease.motion.goal
    return "turned" if ended.how == "reached" and goal is not None and goal.turn is not None else ""


def _what_is_over(state: State, trouble: Reason | None, now: float) -> tuple[Ending, Reason] | None:
    """Return how the lease ends by itself and why, or None while it lives."""
    lease = state.lease
    if lease is None:
        return None
    if trouble:
        return "fault", trouble
    goal = lease.motion.goal
    if goal is not None and (ended := goals.ending(goal, state.settings, now)):
        slowed = Reason(state.limited.code, f"{state.limited.text}, and so slow it does not move")
        return (ended[0], slowed) if ended[1].code == "stuck" and state.limited.direction is not None else ended
    worn = _worn_out(state, lease, now) if lease.motion.power > 0.0 else None
    return ("stopped", worn) if worn else None


def _worn_out(state: State, lease: Lease[ActiveMotion], now: float) -> Reason | None:
    """Return why a motion without an end of its own is over: it ran unattended, or a rule stopped it for too long."""
    settings = state.settings
    if not now - lease.changed < settings.max_run_s:
        return Reason("limit", f"it ran for {settings.max_run_s:g} s unattended")
    if not isnan(state.blocked_since) and not now - state.blocked_since < settings.blocked_s:
        why = f"held still for {settings.blocked_s:g} s: {state.limited.detail}"
        return Reason(state.limited.code, why)
    return None
