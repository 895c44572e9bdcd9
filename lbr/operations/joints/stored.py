"""Motions that the servos' controller plays by itself: order, progress and end."""

from math import isnan

from msgspec.structs import replace

from lbr.leases.decide import with_motion
from lbr.leases.lease import Ending
from lbr.messages.codes import Reason, heard
from lbr.messages.joints import StoredMotion
from lbr.messages.servos import StoredPlay, StoredState
from lbr.operations.joints.move import Move, Stored
from lbr.operations.joints.state import State, age_s, position_rad

TAKEN_S = 1.0
"""The time limit for the driver's acknowledgement."""
GRACE_S = 3.0
"""The delay after its planned end at which a motion counts as over."""
FRESH_S = 0.05


def begin(state: State, motion: StoredMotion, goal: str, now: float) -> tuple[State, Move]:
    """Return the state with an order to the controller, and its motion: nothing gets torque before it plays.

    Counts grow with the clock, so that a restarted process repeats none.
    """
    count = max(state.count + 1, int(now * 1000.0))
    order = Stored(motion=motion, count=count, ordered_at=now)
    return replace(state, count=count, goals=dict.fromkeys(state.on)), Move(
        goal=goal, begun=now, ordered_at=now, stored=order
    )


def play(order: Stored) -> StoredPlay:
    """Return the order for the driver."""
    motion = order.motion
    return StoredPlay(slot=motion.slot, count=order.count, duration_s=motion.duration_s, limp=motion.limp)


def begun_playing(state: State, now: float) -> State:
    """Apply the driver's report; once the controller plays, it has every servo."""
    lease, move = state.leases.live, state.move
    if lease is None or move is None or move.stored is None or not isnan(move.stored.playing):
        return state
    report = _report_of(state, move.stored)
    if report is None or report.phase not in {"playing", "over"}:
        return state
    begun = replace(move, stored=replace(move.stored, playing=now))
    fit = frozenset(name for name, servo in state.seen.items() if not servo.latched)
    state = replace(state, on=fit, goals=dict.fromkeys(fit), strength={}, switched=now, unread=state.unread - fit)
    return replace(state, leases=with_motion(state.leases, begun))


def ending(state: State, order: Stored, now: float) -> tuple[Ending, Reason] | None:
    """Return how it ended and why, or None while it plays."""
    report, slot = _report_of(state, order), order.motion.slot
    if report is None:
        servos = state.servos
        reason = servos.reason or f"their driver reports {servos.phase}" if servos is not None else state.servos_gone
        why = Reason("not_followed", f"the controller does not play slot {slot}: {reason}")
        return ("fault", why) if now - order.ordered_at > TAKEN_S else None
    if report.phase == "failed":
        return "fault", heard(report.code, report.reason or f"the controller did not play slot {slot}")
    if report.phase == "over":
        return "reached", Reason("done", f"slot {slot} was played in {now - _since(order):.2f} s")
    if now - _since(order) < order.motion.duration_s + GRACE_S:
        return None
    if isnan(order.playing):
        why = Reason("timeout", f"the controller did not begin to play slot {slot}: {report.reason or 'it waits'}")
        return "fault", why
    text = f"slot {slot} was played for its time; its end was not reported"
    return "reached", Reason("done", text, cause="time_over")


def after(state: State, order: Stored, now: float) -> State:
    """Return the state after its end: joints at its pose, unless measured elsewhere since; or released."""
    if order.motion.limp:
        return replace(state, on=frozenset(), goals={}, resting=state.on, released_at=now)
    goals = {name: _afterwards(state, name, order.motion, now) for name in state.on}
    return replace(state, goals=goals, switched=now)


def left_s(order: Stored, now: float) -> float:
    """Return the remaining time."""
    return max(0.0, order.motion.duration_s - max(0.0, now - _since(order)))


def busy(state: State, now: float) -> Reason | None:
    """Return why nothing else moves, or None."""
    lease = state.leases.live
    if lease is None or lease.motion.stored is None:
        return None
    order = lease.motion.stored
    return Reason("busy", f"busy: the controller plays slot {order.motion.slot} for {left_s(order, now):.1f} s more")


def _since(order: Stored) -> float:
    return order.ordered_at if isnan(order.playing) else order.playing


def _report_of(state: State, order: Stored) -> StoredState | None:
    """Return the driver's report on this motion."""
    report = state.servos.stored if state.servos is not None else None
    return report if report is not None and report.count == order.count else None


def _afterwards(state: State, name: str, motion: StoredMotion, now: float) -> float | None:
    """Return a joint's position in the pose, or None if it was measured elsewhere: it is held there."""
    pose = motion.pose.get(name)
    found = position_rad(state, name) if age_s(state, name, now) <= FRESH_S else None
    there = found is None or (pose is not None and abs(found - pose) <= state.settings.tolerance_rad)
    return pose if there else None
