"""The motion under way: how it begins, where its joints are to be now, when it is over; and the setpoint of all this."""

from math import inf, isnan, nan

from msgspec.structs import replace

from lbr.messages.joints import JointsCommand, KeyFrame
from lbr.messages.servos import ServoGoal, ServoSetpoint
from lbr.operations.joints import trajectory
from lbr.operations.joints.asked import frames
from lbr.operations.joints.state import Move, Setpoint, State, joint_trouble, position_rad
from lbr.operations.leasing.state import Ending

LONGEST_STEP_S = 0.05
"""A loop that was held up goes on from where it was, it does not jump."""
LONGEST_S = 3600.0
MARGIN_RAD = 0.1
FRESH_S = 0.05
REST_S = 0.1
FOLLOWING_S = 0.3
"""The driver says within this time that the servos follow."""
NOTABLE_STRETCH = 1.01


def begin(state: State, command: JointsCommand, goal: str, now: float) -> Move:
    """Return the motion that a command asks for, from where its joints were told to be last."""
    return Move(goal=goal, begun=now, trajectory=_plan(state, command, _frames(state, command)), told=now)


def instead(move: Move, other: Move) -> Move:
    """Return what follows a motion under the same lease; however often that happens, the servos are to follow it."""
    return replace(other, told=move.told, followed=move.followed)


def append(state: State, move: Move, command: JointsCommand) -> Move:
    """Return a motion that goes on through more key frames after those that it still has before it."""
    way = move.trajectory
    assert way is not None
    behind = trajectory.passed(way, move.elapsed_s)
    ahead = trajectory.ahead(way, move.elapsed_s)
    planned = _plan(state, command, (*ahead, *_frames(state, command)))
    return replace(move, trajectory=planned, elapsed_s=0.0, passed=move.passed + behind, arrived=nan)


def frames_ahead(move: Move) -> int:
    """Return how many key frames it has still before it."""
    way = move.trajectory
    return 0 if way is None else len(way.times_s) - 1 - trajectory.passed(way, move.elapsed_s)


def note(state: State, move: Move, command: JointsCommand) -> str:
    """Return what the asker should know: that it takes longer than asked for, and because of which joint."""
    way = move.trajectory
    asked_for = command.frames or command.duration_s is not None or command.speed_rps is not None
    if way is None or not asked_for or way.stretch < NOTABLE_STRETCH:
        return ""
    limit_rps = state.body.joints[way.slowest].speed_rps
    asked_s = way.duration_s / way.stretch
    return (
        f"takes {way.duration_s:.2f} s instead of {asked_s:.2f}: {way.slowest} goes no faster than {limit_rps:g} rad/s"
    )


def advance(state: State, now: float) -> State:
    """Return the state with every joint of the motion where it is to be now."""
    elapsed_s = min(max(0.0, now - state.ticked), LONGEST_STEP_S)  # this way round, NaN is no time
    state, hold = replace(state, ticked=now), state.holding.hold
    if hold is None or hold.motion.trajectory is None:
        return state
    way, move = hold.motion.trajectory, hold.motion
    move = replace(move, elapsed_s=min(move.elapsed_s + elapsed_s, way.duration_s))
    if isnan(move.arrived) and move.elapsed_s >= way.duration_s:
        move = replace(move, arrived=now)
    goals = {**state.goals, **trajectory.positions(way, move.elapsed_s)}
    holding = replace(state.holding, hold=replace(hold, motion=move))
    return replace(state, holding=holding, goals=goals)


def ending(state: State, trouble: str, now: float) -> tuple[Ending, str] | None:
    """Return how the motion ends now and why, or None while it goes on; `trouble` is that of all servos."""
    move = state.move
    if move is None or move.trajectory is None:
        return None
    why = trouble or next((why for name in move.joints if (why := _fault(state, name, now))), "")
    if why or (why := _not_followed(state, move, now)):
        return "fault", why
    return None if isnan(move.arrived) else _arrival(state, move, move.trajectory.targets, now)


def followed(state: State) -> State:
    """Return the state in which it is known that the servos follow the motion, if the driver says so."""
    hold = state.holding.hold
    if hold is None or hold.motion.followed or state.servos is None or state.servos.phase != "following":
        return state
    move = replace(hold.motion, followed=True)
    return replace(state, holding=replace(state.holding, hold=replace(hold, motion=move)))


def setpoint(state: State) -> Setpoint:
    """Return what the servos are to do now."""
    hold = state.holding.hold
    goals = tuple(_goal(state, name) for name in state.body.joints)
    message = ServoSetpoint(goals=goals, lost=state.lost, halt=state.halt, lease=hold.lease if hold else "")
    return Setpoint(message=message)


def freeze(state: State) -> State:
    """Return the state with every joint held where it was measured.

    One that nobody moves and that is where it should be keeps its goal, or it would sag a little with every stop.
    """
    moved = frozenset(state.move.joints if state.move is not None else ())
    goals = {name: _here_rad(state, name, None if name in moved else state.goals.get(name)) for name in state.on}
    return replace(state, goals=goals, halt=state.halt + 1)


def measured(state: State, name: str) -> float | None:
    """Return where a joint is to be held, so that it does not move: where it is, or the limit that it is just beyond.

    None, which has the driver hold it where it is, if that was not measured just now, or is far beyond.
    """
    found = position_rad(state, name)
    far = found is None or state.body.beyond_rad(name, found) > MARGIN_RAD
    return None if found is None or far or not _age_s(state, name) <= FRESH_S else state.body.within(name, found)


def as_found(state: State, name: str) -> float | None:
    """Return where a joint is to be held that somebody else held before: where that was, if it is there."""
    servo = state.seen.get(name)
    goal = None if servo is None or servo.goal_rad is None else state.body.joint_rad(name, servo.goal_rad)
    return _here_rad(state, name, None if goal is None or state.body.beyond_rad(name, goal) > 0.0 else goal)


def held_again(state: State) -> State:
    """Return the state in which somebody cares again; joints that gave way meanwhile are held where they are by now."""
    return replace(freeze(state), lost=False) if state.lost else state


def _fault(state: State, name: str, now: float) -> str:
    return joint_trouble(state, name, now) or ("" if name in state.on else f"{name} has no torque any more")


def _not_followed(state: State, move: Move, now: float) -> str:
    """Say that the driver holds the servos, although it is told otherwise."""
    servos = state.servos
    if servos is None or servos.phase == "following" or not (move.followed or now - move.told > FOLLOWING_S):
        return ""
    return f"the servos do not follow: {servos.reason or f'their driver says {servos.phase}'}"


def _arrival(state: State, move: Move, targets: dict[str, float], now: float) -> tuple[Ending, str] | None:
    """Return that every joint is where it was to be, or that the time for it is over."""
    away = ((_away_rad(state, name, target), name) for name, target in targets.items())
    worst_rad, name = max(away, default=(0.0, ""))
    if worst_rad <= state.settings.tolerance_rad:
        return "reached", f"reached in {now - move.begun:.2f} s"
    if now - move.arrived < state.settings.settle_s:
        return None
    return "reached", f"over after {now - move.begun:.2f} s, but {name} is {worst_rad:.2f} rad away from its goal"


def _here_rad(state: State, name: str, goal: float | None) -> float | None:
    """Return where a joint is held: at its goal, if it is there, or it would sag anew; else where it is."""
    found = position_rad(state, name)
    if found is None or goal is None or not abs(goal - found) <= state.settings.tolerance_rad:
        return measured(state, name)
    return goal


def _age_s(state: State, name: str) -> float:
    servo = state.seen.get(name)
    return inf if servo is None or servo.age_s is None else servo.age_s + max(0.0, state.clock - state.servos_at)


def _frames(state: State, command: JointsCommand) -> tuple[KeyFrame, ...]:
    """Return the key frames of a command; positions take what it says, or as long as its speed needs for the longest way."""
    asked_s = command.duration_s
    if command.positions and asked_s is None and command.speed_rps is not None:
        (frame,) = frames(command, state.body, trajectory.SHORTEST_S)
        longest_rad = max(abs(goal - _start_rad(state, name)) for name, goal in frame.positions.items())
        asked_s = min(longest_rad / command.speed_rps, LONGEST_S)
    return frames(command, state.body, asked_s or trajectory.SHORTEST_S)


def _plan(state: State, command: JointsCommand, through: tuple[KeyFrame, ...]) -> trajectory.Trajectory:
    named = {name for frame in through for name in frame.positions}
    start = {name: _start_rad(state, name) for name in state.body.joints if name in named}
    limits_rps = {name: state.body.joints[name].speed_rps for name in start}
    move = state.move
    way = move.trajectory if move is not None else None
    speeds_rps = trajectory.speeds(way, move.elapsed_s) if move is not None and way is not None else None
    return trajectory.plan(start, through, limits_rps, command.interpolation, speeds_rps)


def _start_rad(state: State, name: str) -> float:
    goal = state.goals.get(name)
    start = position_rad(state, name) if goal is None else goal
    assert start is not None
    return start


def _away_rad(state: State, name: str, target: float) -> float:
    found = position_rad(state, name)
    return inf if found is None else abs(found - target)


def _goal(state: State, name: str) -> ServoGoal:
    joint, goal = state.body.joints[name], state.goals.get(name)
    rests = name in state.resting and state.clock - state.let_go < REST_S
    if rests or name not in state.on:
        return ServoGoal(id=joint.device_id, torque=0.0)
    position = None if goal is None else state.body.servo_rad(name, goal)
    return ServoGoal(id=joint.device_id, position_rad=position, speed_rps=joint.speed_rps, torque=1.0)
