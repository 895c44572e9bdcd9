"""The checks of a drive command before it moves anything; the first objection refuses it."""

from math import isfinite

from msgspec import inspect

from lbr.leases import rules
from lbr.leases.ask import Ask
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand, TwistCommand
from lbr.operations.drive import distance_goal, turn_goal
from lbr.operations.drive.command import Motion, sides_of
from lbr.operations.drive.goals import not_plausible
from lbr.operations.drive.limits import limit
from lbr.operations.drive.rules import Limit
from lbr.operations.drive.state import ActiveMotion, Command, State, motors_trouble


def judge(state: State, event: Command, ask: Ask[ActiveMotion]) -> Reason | Limit:
    """Return the reason of a refusal, or else the rules' limit at full speed.

    A renewal passes fewer checks.
    """
    command, moves, renewed, now = event.command, ask.request.moves, ask.wants == "renewal", ask.now
    why = _form(state, command) or rules.refusal(ask, motors_trouble(state, now))
    if why is None and moves and not renewed:
        why = _limits(state, command, now)
    if why is not None:
        return why
    limited = limit(state, sides_of(command, state.settings, state.base), now)
    if renewed:
        return limited
    if not limited.scale > 0.0:  # no new motion starts towards an obstacle
        return Reason(limited.code, limited.detail)
    return _checks(event) or limited


def _form(state: State, command: Motion) -> Reason | None:
    """Refuse numbers that are not finite or outside their bounds, and unknown sensors."""
    for name, low, high in BOUNDS[type(command)]:
        value = getattr(command, name)
        if not (isfinite(value) and low <= value <= high):
            return Reason("bad_value", f"{name} {value:g} is outside {low:g} to {high:g}")
    if isinstance(command, DriveCommand) and command.sensor not in state.sensors.singles and _uses_sensor(command):
        known = ", ".join(state.sensors.singles) or "none: range_sensor has no row of a single distance"
        return Reason("unknown_name", f"sensor '{command.sensor}' is not one of {known}")
    return None


def _uses_sensor(command: DriveCommand) -> bool:
    """Return whether a command uses its sensor: the default name is allowed on a base without that sensor."""
    return command.range_cm > 0.0 or command.sensor != "forward"


def _bounds(command: type[Motion]) -> tuple[tuple[str, float, float], ...]:
    """Return name, least and most of each number in a command, as its message declares them; each needs both."""
    message = inspect.type_info(command)
    assert isinstance(message, inspect.StructType)
    bounds = []
    for field in message.fields:
        number = field.type.type if isinstance(field.type, inspect.Metadata) else field.type
        if isinstance(number, inspect.FloatType):
            assert number.ge is not None, f"{field.name} has no least"
            assert number.le is not None, f"{field.name} has no most"
            bounds.append((field.name, number.ge, number.le))
    return tuple(bounds)


BOUNDS = {command: _bounds(command) for command in (DriveCommand, TurnCommand, HeadingCommand, TwistCommand)}


def _limits(state: State, command: Motion, now: float) -> Reason | None:
    """Check the bounds of a motion: a range within the sensor's reach and not reached yet, a time within the longest
    run.

    A turn needs a known heading, a distance needs known odometry.
    """
    if isinstance(command, TwistCommand):
        aside = command.vy_mps != 0.0 and not state.base.holonomic
        return (
            Reason("bad_value", f"vy_mps {command.vy_mps:g}: this base cannot move sideways, send 0") if aside else None
        )
    if not isinstance(command, DriveCommand):
        return turn_goal.not_possible(command, state.heading, state.settings, now)
    if command.interval_s > state.settings.max_run_s:
        longest_s = state.settings.max_run_s
        return Reason("limit", f"interval_s {command.interval_s:g} is longer than max_run_s {longest_s:g}")
    why = distance_goal.not_possible(command, state.odometry, now)
    return why or not_plausible(command, state.views, state.settings, state.sensors, now)


def _checks(event: Command) -> Reason | None:
    """Check that the user's own checks all agree."""
    for name, verdict in event.checks.items():
        if verdict is None:
            return Reason("check", f"check {name} did not answer")
        if not verdict.accepted:
            why = verdict.reason or "refused without a reason"
            return Reason("check", f"check {name}: {why}", cause=verdict.code)
    return None
