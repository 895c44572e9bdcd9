"""Bounded moves: until a sensor reaches a distance, a way is driven or a time is over, whichever is first. Turns."""

from collections.abc import Mapping
from math import inf, isfinite, isnan, nan
from typing import TypeGuard

from msgspec.structs import replace

from lbr.leases.lease import Ending
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand, GoalResult, HeadingCommand, TurnCommand, TwistCommand
from lbr.messages.sensing import Ranges
from lbr.operations.drive import distance_goal, range_goal, turn_goal
from lbr.operations.drive.command import Motion, moves
from lbr.operations.drive.distance_goal import STANDING_MPS
from lbr.operations.drive.mixing import mix
from lbr.operations.drive.range_goal import RangeGoal
from lbr.operations.drive.rules import USUAL, View, measured_m, towards
from lbr.operations.drive.sensors import Sensors, sees_along
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import Goal, State

FARTHEST_CM = 768.0
LOST_AFTER_S = 0.3
LONGEST_LAG_S = 0.2
"""The greatest assumed age of a reading: without a reported age it is half of the board's cycle, within this limit."""


def bounded(command: Motion) -> TypeGuard[DriveCommand | TurnCommand | HeadingCommand]:
    """Return whether a command is a bounded move, as every turn is."""
    if isinstance(command, (TurnCommand, HeadingCommand)):
        return True
    if isinstance(command, TwistCommand):
        return False
    return moves(command) and (command.range_cm > 0.0 or command.interval_s > 0.0 or command.distance_cm > 0.0)


def not_plausible(
    command: DriveCommand, views: Mapping[str, View], settings: DriveSettings, sensors: Sensors, now: float
) -> Reason | None:
    """Return why a range cannot be driven to, or None; its sensor has a row."""
    if not command.range_cm > 0.0:
        return None
    row = sensors.rows[command.sensor]
    nearest_cm, farthest_cm = round(row.min_m * 100, 6), min(FARTHEST_CM, round(row.max_m * 100, 6))
    if not nearest_cm <= command.range_cm <= farthest_cm:
        return Reason("bad_value", f"range_cm {command.range_cm:g} is outside {nearest_cm:g} to {farthest_cm:g}")
    view = views.get(command.sensor)
    if view is None or not now - view.seen <= LOST_AFTER_S or isnan(view.raw_m):
        return Reason("stale_sensor", f"sensor {command.sensor} has no reading to watch")
    goal = _to_range(command, "", views, settings, now)
    if _reached(goal, view.raw_m):
        there = f"{command.sensor} is {_words(view.raw_m)} already, range_cm is {command.range_cm:g}"
        return Reason("done", there)
    return _out_of_reach(goal, command, settings)


def start(command: DriveCommand | TurnCommand | HeadingCommand, name: str, state: State, now: float) -> Goal:
    """Return the goal of a bounded move that starts now."""
    settings = state.settings
    if isinstance(command, (TurnCommand, HeadingCommand)):
        turn = turn_goal.start(command, state.heading, settings, now)
        return Goal(goal=name, sensor="forward", target_m=nan, closing=False, started=now, turn=turn)
    goal = _to_range(command, name, state.views, settings, now)
    goal = replace(goal, approach=_approach(goal, command, state))
    way = distance_goal.start(command, state.odometry, settings) if command.distance_cm > 0.0 else None
    return replace(goal, way=way)


def _to_range(command: DriveCommand, name: str, views: Mapping[str, View], settings: DriveSettings, now: float) -> Goal:
    view = views.get(command.sensor)
    present_m = nan if view is None else view.raw_m
    target_m = command.range_cm / 100 if command.range_cm > 0.0 else nan
    return Goal(
        goal=name,
        sensor=command.sensor,
        target_m=target_m,
        closing=_closing(command, present_m, target_m, settings),
        started=now,
        ends=now + command.interval_s if command.interval_s > 0.0 else inf,
        last_m=present_m,
        last_seen=nan if view is None else view.seen,
    )


def watch(goal: Goal, ranges: Ranges, now: float, ahead_mps: float, sensors: Sensors = USUAL) -> Goal:
    """Return the goal with its sensor's newest reading; those without a value are ignored until they last too long."""
    if not ranges.tells_of(goal.sensor):
        return goal
    value_m, _ = measured_m(ranges, goal.sensor, sensors)
    overtaken = now < goal.last_seen
    if overtaken or isnan(value_m):
        return goal
    goal = replace(goal, last_m=value_m, last_seen=now)
    if goal.approach is None:
        return goal
    stands, measured_s = ahead_mps <= STANDING_MPS, now - _age_s(ranges, goal.sensor)
    return replace(goal, approach=range_goal.read(goal.approach, _left_m(goal), measured_s, ahead_mps, stands=stands))


def ending(goal: Goal, settings: DriveSettings, now: float) -> tuple[Ending, Reason] | None:
    """Return how a goal ends now and why, or None while it continues."""
    if goal.turn is not None:
        return _turned(goal, goal.turn, settings, now)
    if goal.way is not None and (ended := _travelled(goal, goal.way, now)):
        return ended
    if not isnan(goal.target_m) and (ended := _at_range(goal, now)):
        return ended
    if not now < goal.ends:
        return "interval", Reason("time_over", f"the {goal.ends - goal.started:g} s are over")
    return None


def result(goal: Goal, how: Ending, why: Reason, now: float) -> GoalResult:
    """Return the message about the end of a goal."""
    known = goal.last_m < inf and not isnan(goal.target_m)
    return GoalResult(
        goal=goal.goal,
        result=how,
        reason=why.text,
        code=why.code,
        cause=why.cause,
        range_cm=round(goal.last_m * 100, 1) if known else None,
        elapsed_s=round(now - goal.started, 3),
        turned_deg=_known(goal.turn.turned_deg, 2) if goal.turn else None,
        error_deg=_known(-goal.turn.left_deg, 2) if goal.turn else None,
        distance_m=_known(goal.way.sense * goal.way.travelled_m, 3) if goal.way else None,
        error_m=_known(-goal.way.left_m, 3) if goal.way else None,
    )


def wheels(
    goal: Goal | None, power: float, angle_deg: float, settings: DriveSettings, now: float
) -> tuple[float, float]:
    """Return the powers of the wheels from the goal: as asked, and less near the end of a turn or a way."""
    if goal is not None and goal.turn is not None:
        push = turn_goal.power(goal.turn, settings, now)
        return push, -push
    if goal is not None and goal.way is not None:
        power = distance_goal.power(goal.way, power, settings, now)
    if goal is not None and goal.approach is not None:
        power = range_goal.power(goal.approach, power, settings)
    return mix(power, angle_deg, settings)


def driven(goal: Goal | None, state: State, elapsed_s: float, now: float) -> Goal | None:
    """Return the goal after the wheels had their setpoint for a while."""
    if goal is None:
        return goal
    settings = state.settings
    if goal.approach is not None:
        ahead_mps = abs(state.left + state.right) / 2 * settings.max_speed_mps
        way = range_goal.driven(goal.approach, state.odometry, ahead_mps, elapsed_s, now, settings)
        return replace(goal, approach=way)
    if goal.turn is None:
        return goal
    return replace(goal, turn=turn_goal.driven(goal.turn, state.left, elapsed_s, settings))


def _turned(goal: Goal, turn: turn_goal.TurnGoal, settings: DriveSettings, now: float) -> tuple[Ending, Reason] | None:
    if why := turn_goal.fault(turn, settings, now):
        return "fault", why
    done = turn_goal.is_over(turn, settings)
    return ("reached", Reason("done", turn_goal.ended(turn, now - goal.started))) if done else None


def _travelled(goal: Goal, way: distance_goal.DistanceGoal, now: float) -> tuple[Ending, Reason] | None:
    if why := distance_goal.fault(way, goal.started, now):
        return "fault", why
    done = distance_goal.is_over(way)
    return ("reached", Reason("done", distance_goal.ended(way, now - goal.started))) if done else None


def _at_range(goal: Goal, now: float) -> tuple[Ending, Reason] | None:
    """Return the end of a move to a range; a reading beyond the range ends it at once, without coming to rest."""
    rests = goal.approach is not None and range_goal.is_over(goal.approach)
    if rests or _reached(goal, goal.last_m):
        return "reached", Reason("done", f"{goal.sensor} is {_words(goal.last_m)}")
    if not now - goal.last_seen <= LOST_AFTER_S:
        return "fault", Reason("stale_sensor", f"sensor {goal.sensor} was lost")
    return None


def _known(value: float, digits: int) -> float | None:
    return round(value, digits) if isfinite(value) else None


def _closing(command: DriveCommand, present_m: float, target_m: float, settings: DriveSettings) -> bool:
    """Return whether the distance shrinks: a leading sensor decides, or else the position of the target."""
    parts = towards(*mix(command.power, command.angle_deg, settings))
    leads = {"forward": parts["forward"], "back": parts["back"]}.get(command.sensor)
    if leads is not None and parts["forward"] + parts["back"] > 0.0:
        return leads > 0.0
    return present_m > target_m


def _approach(goal: Goal, command: DriveCommand, state: State) -> RangeGoal | None:
    """Return the approach to rest at the range; None if the sensor does not look along its way."""
    if isnan(goal.target_m) or isnan(goal.last_m) or not sees_along(state.sensors.rows[goal.sensor]):
        return None
    parts = towards(*mix(command.power, command.angle_deg, state.settings))
    along = parts["forward"] + parts["back"] > 0.0
    if not (along and state.sensors.rows[goal.sensor].level):
        return None
    sense = 1.0 if parts["forward"] > 0.0 else -1.0
    return RangeGoal(whole_m=_left_m(goal), marks=((goal.started, 0.0),), sense=sense)


def _age_s(ranges: Ranges, sensor: str) -> float:
    return ranges.ages_s.get(sensor, min(ranges.cycle_s or 0.0, LONGEST_LAG_S) / 2)


def _left_m(goal: Goal) -> float:
    return goal.last_m - goal.target_m if goal.closing else goal.target_m - goal.last_m


def _reached(goal: Goal, value_m: float) -> bool:
    return value_m <= goal.target_m if goal.closing else value_m >= goal.target_m


def _out_of_reach(goal: Goal, command: DriveCommand, settings: DriveSettings) -> Reason | None:
    parts = towards(*mix(command.power, command.angle_deg, settings))
    for rule in settings.rules:
        if rule.sensor == goal.sensor and parts[rule.direction] > 0.0 and goal.target_m < rule.stop_m:
            stop_cm = rule.stop_m * 100
            why = f"range_cm {command.range_cm:g} is out of reach: the {rule.direction} rule stops at {stop_cm:g} cm"
            return Reason("limit", why)
    return None


def _words(value_m: float) -> str:
    return "beyond its reach" if value_m == inf else f"at {value_m * 100:.0f} cm"
