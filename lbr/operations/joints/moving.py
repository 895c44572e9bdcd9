"""The current motion: its start, the joints' positions now, its end, and the setpoint."""

from math import isnan

from msgspec.structs import replace

from lbr.leases.lease import Ending, Setpoint
from lbr.messages.codes import Reason, heard
from lbr.messages.servos import ServoGoal, ServoSetpoint
from lbr.operations.joints import stored
from lbr.operations.joints.move import Move
from lbr.operations.joints.state import REST_S, State, age_s, joint_trouble, position_rad, unmeasured, waits

LONGEST_STEP_S = 0.05
"""The longest step that counts: a loop that was held up continues without a jump."""
MARGIN_RAD = 0.1
FRESH_S = 0.05
FOLLOWING_S = 0.3
"""The time limit for the driver's report that the servos follow."""


def advance(state: State, now: float) -> State:
    """Return the state with every joint of the motion at its position now; time stops while the controller passes no
    goals on."""
    elapsed_s = min(max(0.0, now - state.ticked), LONGEST_STEP_S)  # this way round, NaN is no time
    state, lease = replace(state, ticked=now), state.leases.live
    if lease is None or not lease.motion.joints or waits(state):
        return state
    move = _further(lease.motion, elapsed_s, now)
    leases = replace(state.leases, live=replace(lease, motion=move))
    return replace(state, leases=leases, goals={**state.goals, **move.positions()})


def ending(state: State, trouble: Reason | None, now: float) -> tuple[Ending, Reason] | None:
    """Return how the motion ends now and why, or None while it continues; `trouble` is that of all servos."""
    move = state.move
    if move is None or move.offered:
        return None
    if move.stored is not None:
        return ("fault", trouble) if trouble else stored.ending(state, move.stored, now)
    why = trouble or next((why for name in move.joints if (why := fault(state, name, now))), None)
    if why or (why := _not_followed(state, move, now)):
        return "fault", why
    return _arrival(state, move, now) if move.over and not move.stay else None


def fault(state: State, name: str, now: float) -> Reason | None:
    """Return why a joint would not follow, or that it lost its torque; or None."""
    limp = None if name in state.on else Reason("no_torque", f"{name} has no torque any more")
    return joint_trouble(state, name, now) or limp


def followed(state: State) -> State:
    """Return the state with the motion marked as followed, if the driver reports that."""
    lease = state.leases.live
    if lease is None or lease.motion.followed or state.servos is None or state.servos.phase != "following":
        return state
    move = replace(lease.motion, followed=True)
    return replace(state, leases=replace(state.leases, live=replace(lease, motion=move)))


def setpoint(state: State) -> Setpoint:
    """Return the setpoint of the servos."""
    lease, move = state.leases.live, state.move
    goals = tuple(_goal(state, name) for name in state.body.joints)
    play = stored.play(move.stored) if move is not None and move.stored is not None else None
    lease_id = lease.id if lease else state.feet.lease if state.feet else ""
    return Setpoint(message=ServoSetpoint(goals=goals, lost=state.lost, halt=state.halt, lease=lease_id, stored=play))


def freeze(state: State) -> State:
    """Return the state with every joint held where it was measured.

    A joint at rest near its goal keeps that goal, or it would sag a little with every stop.
    """
    moved = frozenset(state.move.joints if state.move is not None else ())
    moved |= frozenset(state.feet.names if state.feet is not None else ())
    goals = {name: _held_rad(state, name, None if name in moved else state.goals.get(name)) for name in state.on}
    lost = state.lost or (state.feet is not None and state.feet.lost)
    return replace(state, goals=goals, halt=state.halt + 1, ticked=state.clock, feet=None, lost=lost)


def measured(state: State, name: str) -> float | None:
    """Return the position at which a joint is held, so that it does not move: measured, or the limit just passed.

    None makes the driver hold it where it is: the measurement is old, or far beyond the limits. In an open loop it is
    the last commanded position.
    """
    if state.settings.open_loop and unmeasured(state, name, state.clock):
        return state.goals.get(name)
    measured_rad = position_rad(state, name)
    far = measured_rad is None or state.body.beyond_rad(name, measured_rad) > MARGIN_RAD
    return (
        None
        if measured_rad is None or far or not age_s(state, name, state.clock) <= FRESH_S
        else state.body.within(name, measured_rad)
    )


def as_found(state: State, name: str) -> float | None:
    """Return the position at which to hold a joint that another holder held: its goal then, if it is there."""
    servo = state.seen.get(name)
    goal = None if servo is None or servo.goal_rad is None else state.body.joint_rad(name, servo.goal_rad)
    return _held_rad(state, name, None if goal is None or state.body.beyond_rad(name, goal) > 0.0 else goal)


def held_again(state: State) -> State:
    """Return the state with a holder again; joints that gave way meanwhile are held at their position now."""
    return replace(freeze(state), lost=False) if state.lost else replace(state, feet=None)


def interrupted(state: State) -> State:
    """Return the state without the controller's motion, if there is one: another sender has taken the lease."""
    return freeze(state) if state.move is not None and state.move.stored is not None else state


def _not_followed(state: State, move: Move, now: float) -> Reason | None:
    """Return a reason if the driver holds the servos against its setpoints, or None."""
    servos = state.servos
    if servos is None or servos.phase == "following" or waits(state):
        return None
    if not (move.followed or now - max(move.ordered_at, state.waited) > FOLLOWING_S):
        return None
    why = servos.reason or f"their driver reports {servos.phase}"
    return heard(servos.code or "not_followed", f"the servos do not follow: {why}")


def _further(move: Move, elapsed_s: float, now: float) -> Move:
    """Return a motion that has continued for this long."""
    beside = {}
    for name, one in move.beside.items():
        gone_s = min(one.elapsed_s + elapsed_s, one.trajectory.duration_s)
        arrived = now if isnan(one.arrived) and gone_s >= one.trajectory.duration_s else one.arrived
        beside[name] = replace(one, elapsed_s=gone_s, arrived=arrived)
    move = replace(move, beside=beside) if beside else move
    way = move.trajectory
    if way is None:
        return move
    gone_s = min(move.elapsed_s + elapsed_s, way.duration_s)
    arrived = now if isnan(move.arrived) and gone_s >= way.duration_s else move.arrived
    return replace(move, elapsed_s=gone_s, arrived=arrived)


def _arrival(state: State, move: Move, now: float) -> tuple[Ending, Reason] | None:
    """Return that every joint has arrived, or that the time for it is over."""
    away = ((_away_rad(state, name, target), name) for name, target in move.targets.items())
    worst_rad, name = max(away, default=(0.0, ""))
    if worst_rad <= state.settings.tolerance_rad:
        return "reached", Reason("done", f"reached in {now - move.begun:.2f} s")
    if now - move.over_since < state.settings.settle_s:
        return None
    off = f"{name} is {worst_rad:.2f} rad away from its goal"
    text = f"over after {now - move.begun:.2f} s, but {off}"
    return "reached", Reason("done", text, cause="off_goal", note=off)


def _held_rad(state: State, name: str, goal: float | None) -> float | None:
    """Return the position at which a joint is held: its goal, if it is near that, or it would sag again; else its
    position."""
    present_rad = position_rad(state, name)
    if present_rad is None or goal is None or not abs(goal - present_rad) <= state.settings.tolerance_rad:
        return measured(state, name)
    return goal


def _away_rad(state: State, name: str, target: float) -> float:
    """Return the measured distance from a target; an unmeasured joint, in an open loop, counts as arrived."""
    found = position_rad(state, name)
    return 0.0 if found is None or unmeasured(state, name, state.clock) else abs(found - target)


def _goal(state: State, name: str) -> ServoGoal:
    joint, goal = state.body.joints[name], state.goals.get(name)
    rests = name in state.resting and state.clock - state.released_at < REST_S
    if rests or name not in state.on:
        return ServoGoal(id=joint.device_id, torque=0.0)
    strength = state.strength.get(name, 1.0)
    position = None if goal is None else state.body.servo_rad(name, goal)
    return ServoGoal(id=joint.device_id, position_rad=position, speed_rps=joint.speed_rps, torque=strength)
