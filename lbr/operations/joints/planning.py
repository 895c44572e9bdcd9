"""The ways of the joints for a command: through key frames, appended to them, or joined beside them."""

from math import copysign, inf, nan

from msgspec.structs import replace

from lbr.messages.joints import JointsCommand, KeyFrame
from lbr.operations.joints import trajectory
from lbr.operations.joints.move import Move, Way
from lbr.operations.joints.request import frames, named
from lbr.operations.joints.state import REST_S, State, position_rad, unmeasured
from lbr.operations.joints.trajectory import Trajectory

LONGEST_S = 3600.0
NOTABLE_STRETCH = 1.01
UNKNOWN_S = 2.0
"""The assumed time to a goal for a joint at an unknown position: its servo goes there at its weakest."""
SMOOTHEST = 1.5
"""The time of a smooth way, as a multiple of a straight one at the same greatest speed; enough from any lesser speed.
"""


def begin(state: State, command: JointsCommand, goal: str, now: float, idle_s: float = 0.0) -> Move:
    """Return the motion for a command, from the last commanded positions of its joints."""
    move = Move(goal=goal, begun=now, ordered_at=now, stay=command.stay)
    if command.join:
        return joined(state, move, command, now, idle_s)
    rest_s = max((_rest_s(state, name, now) for name in named(command, state.body)), default=0.0)
    return replace(move, trajectory=_plan(state, command, _frames(state, command, now), now), elapsed_s=0.0 - rest_s)


def instead(move: Move, other: Move) -> Move:
    """Return the motion that replaces another under the same lease; the servos get no more time to follow."""
    return replace(other, ordered_at=move.ordered_at, followed=move.followed)


def append(state: State, move: Move, command: JointsCommand, now: float) -> Move:
    """Return the motion with further key frames after its remaining ones."""
    way, behind, ahead = move.trajectory, 0, tuple[KeyFrame, ...]()
    if way is not None:
        behind = trajectory.passed(way, move.elapsed_s)
        ahead = trajectory.ahead(way, move.elapsed_s)
    planned = _plan(state, command, (*ahead, *_frames(state, command, now)), now)
    beside = {name: one for name, one in move.beside.items() if name not in planned.knots}
    return replace(move, trajectory=planned, elapsed_s=0.0, passed=move.passed + behind, arrived=nan, beside=beside)


def joined(state: State, move: Move, command: JointsCommand, now: float, idle_s: float = 0.0) -> Move:
    """Return the motion with a new way for each joint of the command, the others unchanged.

    A joint that has stood for `idle_s` counts as started that long ago.
    """
    (frame,) = frames(command, state.body, trajectory.SHORTEST_S)
    speeds_rps = {} if state.move is None else state.move.speeds()
    moved = set() if state.move is None else state.move.moved_since(now - idle_s)
    ways = {}
    for name, target in frame.positions.items():
        way = _way(state, command, name, target, speeds_rps.get(name, 0.0), now)
        rest_s = _rest_s(state, name, now)
        ways[name] = Way(trajectory=way, elapsed_s=-rest_s if rest_s > 0.0 else 0.0 if name in moved else idle_s)
    left = {name: way for name, way in move.beside.items() if not _rests(state, name, way, now)}
    base = None if move.trajectory is None else trajectory.without(move.trajectory, ways)
    return replace(move, trajectory=base, beside={**left, **ways}, stay=command.stay)


def frames_ahead(move: Move) -> int:
    """Return the number of its remaining key frames."""
    way = move.trajectory
    return 0 if way is None else len(way.times_s) - 1 - trajectory.passed(way, move.elapsed_s)


def note(state: State, move: Move, command: JointsCommand) -> str:
    """Return a note for the sender: that the motion takes longer than requested, and because of which joint."""
    asked_for = command.frames or command.duration_s is not None or command.speed_rps is not None
    if not asked_for:
        return ""
    if command.join:
        return _note_of_joined(state, move, command)
    way = move.trajectory
    if way is None or way.stretch < NOTABLE_STRETCH:
        return ""
    return _takes(state, way.duration_s, way.duration_s / way.stretch, way.slowest)


def start_rad(state: State, name: str, now: float) -> float | None:
    """Return the start of a joint's way: its last commanded position, or else the measured one; None if unknown."""
    goal = state.goals.get(name)
    if goal is not None:
        return goal
    return None if state.settings.open_loop and unmeasured(state, name, now) else position_rad(state, name)


def _frames(state: State, command: JointsCommand, now: float) -> tuple[KeyFrame, ...]:
    """Return the key frames of a command; with a speed instead of a duration, the longest way decides the time."""
    asked_s = command.duration_s
    if command.positions and asked_s is None and command.speed_rps is not None:
        (frame,) = frames(command, state.body, trajectory.SHORTEST_S)
        starts = {name: start_rad(state, name, now) for name in frame.positions}
        ways_rad = [abs(goal - start) for name, goal in frame.positions.items() if (start := starts[name]) is not None]
        asked_s = min(max(ways_rad, default=0.0) / command.speed_rps, LONGEST_S)
    first, *more = frames(command, state.body, asked_s or trajectory.SHORTEST_S)
    if any(start_rad(state, name, now) is None for name in named(command, state.body)):
        first = replace(first, duration_s=max(first.duration_s, UNKNOWN_S))
    return (first, *more)


def _plan(state: State, command: JointsCommand, through: tuple[KeyFrame, ...], now: float) -> Trajectory:
    first: dict[str, float] = {}
    for frame in through:
        first = {**frame.positions, **first}
    places = {name: start_rad(state, name, now) for name in state.body.joints if name in first}
    start = {name: first[name] if place is None else place for name, place in places.items()}
    limits_rps = {name: state.body.joints[name].speed_rps for name in start}
    speeds_rps = state.move.speeds() if state.move is not None else None
    return trajectory.plan(start, through, limits_rps, command.interpolation, speeds_rps)


def _way(state: State, command: JointsCommand, name: str, target: float, speed_rps: float, now: float) -> Trajectory:
    """Return the way of one joint, as fast as its row and the command allow, from its present speed."""
    limit_rps = state.body.joints[name].speed_rps
    place = start_rad(state, name, now)
    start = target if place is None else place
    factor = SMOOTHEST if command.interpolation == "smooth" else 1.0
    least_s = UNKNOWN_S if place is None else factor * abs(target - start) / limit_rps
    step = KeyFrame(
        positions={name: target}, duration_s=max(least_s, _asked_s(command, abs(target - start)), trajectory.SHORTEST_S)
    )
    begun_rps = _begun_rps(target - start, step.duration_s, speed_rps, limit_rps)
    return trajectory.plan({name: start}, (step,), {name: limit_rps}, command.interpolation, {name: begun_rps})


def _begun_rps(way_rad: float, takes_s: float, speed_rps: float, limit_rps: float) -> float:
    """Return the initial speed: at once the greatest, so that the joint only slows down; but a reversal is smooth."""
    if speed_rps * way_rad < 0.0:
        return 0.0
    fastest_rps = max(abs(speed_rps), SMOOTHEST * abs(way_rad) / takes_s)
    return copysign(min(fastest_rps, limit_rps), way_rad)


def _asked_s(command: JointsCommand, way_rad: float) -> float:
    if command.duration_s is not None:
        return command.duration_s
    return 0.0 if command.speed_rps is None else min(way_rad / command.speed_rps, LONGEST_S)


def _note_of_joined(state: State, move: Move, command: JointsCommand) -> str:
    """Return a note about the slowest of the joined joints, if it takes notably longer than requested."""
    slowest = ("", 0.0, inf)
    for name in named(command, state.body):
        way = move.beside[name].trajectory
        first, last = way.knots[name][0], way.knots[name][-1]
        asked_s = max(_asked_s(command, abs(last - first)), trajectory.SHORTEST_S)
        if way.duration_s / asked_s > max(NOTABLE_STRETCH, slowest[1] / slowest[2]):
            slowest = (name, way.duration_s, asked_s)
    name, takes_s, asked_s = slowest
    return _takes(state, takes_s, asked_s, name) if name else ""


def _takes(state: State, takes_s: float, asked_s: float, name: str) -> str:
    limit_rps = state.body.joints[name].speed_rps
    return f"takes {takes_s:.2f} s instead of {asked_s:.2f}: {name} goes no faster than {limit_rps:g} rad/s"


def _rest_s(state: State, name: str, now: float) -> float:
    """Return how long setpoints must still show a released joint without torque."""
    return max(0.0, REST_S - (now - state.released_at)) if name in state.resting else 0.0


def _rests(state: State, name: str, way: Way, now: float) -> bool:
    """Return whether a joint has come to the end of its way, and to its goal as far as is known."""
    if not way.arrived <= now:
        return False
    present_rad = position_rad(state, name)
    return present_rad is None or abs(present_rad - way.trajectory.targets[name]) <= state.settings.tolerance_rad
