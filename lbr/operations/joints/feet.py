"""Stepping to the feet: a motion stopped in mid-step continues to the nearest pose in which the robot stands. Pure.

This process does so, without a holder: a driver without its setpoints holds at once. A motion without a stable key
frame, and anything but a motion, is held at once.
"""

from math import ceil

from msgspec.structs import replace

from lbr.leases.lease import Reply, Stop
from lbr.messages.codes import Reason
from lbr.messages.joints import KeyFrame
from lbr.messages.leases import CommandReply
from lbr.operations.joints import trajectory
from lbr.operations.joints.move import Move, ToFeet
from lbr.operations.joints.moving import LONGEST_STEP_S, fault, freeze
from lbr.operations.joints.state import State, age_s, position_rad, servos_trouble, waits
from lbr.operations.joints.trajectory import Trajectory

LONGEST_S = 0.8
"""The promised limit: a robot stands this long after a stop."""
STRAIGHT_S = 0.3
"""The least time of a straight way to a pose: in simulation 0.1 to 0.8 s left a robot on its feet alike."""
SMOOTHEST = 1.5
"""The time of a smooth way, as a multiple of a straight one at the same greatest speed."""
AGAIN_S = 0.1
"""The time within which one stop arrives by several ways, all sent at once; people do not press again so fast."""
FOLLOWED_S = 0.3
MEASURED_S = 0.3


def begin(state: State, move: Move, lease: str, stop: Stop | None, now: float, *, lost: bool) -> State | None:
    """Return the state in which the robot steps to its feet; None if no stable pose is within its time."""
    if not state.adopted:
        return None
    feet = ToFeet(lease=lease, begun=now, until=now + LONGEST_S, lost=lost)
    if stop is not None and not lost:
        feet = replace(feet, stops={_way(stop): stop.received})
    if move.stored is not None:
        if not (move.stored.motion.stable and move.stored.motion.pose):
            return None
        pose = move.stored.motion.pose
        feet = replace(feet, pose=pose, names=tuple(pose))
        return replace(state, halt=state.halt + 1, feet=feet)  # the new count makes the driver end it
    way = _way_on(state, move)
    if way is None or any(fault(state, name, now) for name in way.knots):
        return None
    left = tuple(name for name in move.joints if name not in way.knots)
    here = freeze(state).goals if left else {}
    goals = {**state.goals, **{name: here[name] for name in left if name in here}}
    feet = replace(feet, trajectory=way, names=tuple(way.knots), followed=move.followed)
    return replace(state, goals=goals, ticked=now, feet=feet)


def again(state: State, stop: Stop) -> State | None:
    """Return the state after a further stop, if it is the first, or the same by another way; None: hold at once."""
    feet = state.feet
    if feet is None:
        return None
    way = _way(stop)
    if stop.lost or not feet.stops:
        known = feet.stops if stop.lost else {way: stop.received}
        return replace(state, feet=replace(feet, stops=known))
    if way in feet.stops:
        return state if stop.received - feet.stops[way] <= AGAIN_S else None
    if all(origin != way[0] for origin, _ in feet.stops):
        return None
    return replace(state, feet=replace(feet, stops={**feet.stops, way: stop.received}))


def advance(state: State, now: float) -> State:
    """Return the state a step nearer to its feet; held, once it stands or something interferes."""
    feet = state.feet
    if feet is None:
        return state
    elapsed_s = min(max(0.0, now - state.ticked), LONGEST_STEP_S)  # this way round, NaN is no time
    if not now < feet.until or _ends(state, feet, now):
        return freeze(state)
    state = replace(state, ticked=now)
    if feet.trajectory is None:
        return _straight(state, feet, now)
    gone_s = feet.elapsed_s + elapsed_s
    goals = {**state.goals, **trajectory.positions(feet.trajectory, gone_s)}
    followed = feet.followed or (state.servos is not None and state.servos.phase == "following")
    if gone_s < feet.trajectory.duration_s:
        return replace(state, goals=goals, feet=replace(feet, elapsed_s=gone_s, followed=followed))
    return replace(state, goals=goals, feet=None, lost=state.lost or feet.lost)


def reply(state: State, now: float) -> Reply:
    """Return the reply to a stop: the joints hold, or step to their feet first."""
    if state.feet is None:
        return Reply(message=CommandReply(accepted=True, reason="stopped"))
    within_s = max(1, ceil(round(left_s(state.feet, now) * 10, 3))) / 10
    text = f"steps to its feet, within {within_s:.1f} s; stop again to hold at once"
    return Reply(message=CommandReply(accepted=True, reason=text, code="to_feet"))


def left_s(feet: ToFeet, now: float) -> float:
    """Return the longest remaining time."""
    if feet.trajectory is None:
        return feet.until - now
    return min(feet.until - now, feet.trajectory.duration_s - feet.elapsed_s)


def _way(stop: Stop) -> tuple[str, str]:
    return stop.by or stop.source, stop.source


def _way_on(state: State, move: Move) -> Trajectory | None:
    """Return the way to the nearest stable frame ahead, or else back to the last one behind, if short enough."""
    way = move.trajectory
    if way is None or not way.stable:
        return None
    speeds = trajectory.speeds(way, move.elapsed_s)
    start = trajectory.positions(way, move.elapsed_s)
    frames = trajectory.ahead(way, max(0.0, move.elapsed_s))
    limits_rps = {name: state.body.joints[name].speed_rps for name in start}
    near_s = 0.0
    for at, frame in enumerate(frames):
        near_s += frame.duration_s
        if near_s > LONGEST_S:
            break
        if frame.stable:
            planned = trajectory.plan(start, frames[: at + 1], limits_rps, speeds_rps=speeds)
            if planned.duration_s < LONGEST_S:
                return planned
    behind = max((at for at in way.stable if way.times_s[at] <= move.elapsed_s), default=None)
    if behind is None:
        return None
    return _direct(start, {name: values[behind] for name, values in way.knots.items()}, limits_rps, LONGEST_S, speeds)


def _direct(
    start: dict[str, float],
    pose: dict[str, float],
    limits_rps: dict[str, float],
    most_s: float,
    speeds: dict[str, float],
) -> Trajectory | None:
    """Return the straight way to a pose, if it is short enough."""
    longest_s = max((SMOOTHEST * abs(pose[name] - start[name]) / limits_rps[name] for name in pose), default=0.0)
    frame = KeyFrame(positions=pose, duration_s=max(STRAIGHT_S, longest_s))
    planned = trajectory.plan(start, (frame,), limits_rps, speeds_rps=speeds)
    return planned if planned.duration_s < most_s else None


def _straight(state: State, feet: ToFeet, now: float) -> State:
    """Go straight to the pose, once joints moved by the controller were measured."""
    if waits(state):
        return state
    start = {}
    for name in feet.pose:
        measured_rad = position_rad(state, name)
        if name not in state.on:
            continue
        if measured_rad is None or now - age_s(state, name, now) <= feet.begun or age_s(state, name, now) > MEASURED_S:
            return state  # until its time is over
        start[name] = state.body.within(name, measured_rad)
    limits_rps = {name: state.body.joints[name].speed_rps for name in start}
    pose = {name: feet.pose[name] for name in start}
    way = _direct(start, pose, limits_rps, feet.until - now, {}) if start else None
    if way is None:
        return freeze(state)
    return replace(state, goals={**state.goals, **start}, feet=replace(feet, trajectory=way, names=tuple(way.knots)))


def _ends(state: State, feet: ToFeet, now: float) -> Reason | None:
    """Return why it ends early, or None."""
    if why := servos_trouble(state, now):
        return why
    if feet.trajectory is None:
        return None
    servos = state.servos
    silent = servos is not None and servos.phase != "following" and not waits(state)
    if silent and (feet.followed or now - feet.begun > FOLLOWED_S):
        return Reason("not_followed", "the servos do not follow")
    return next((why for name in feet.trajectory.knots if (why := fault(state, name, now))), None)
