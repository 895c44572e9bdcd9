"""The chain a drive command passes before it moves anything; the first link that objects refuses it."""

from collections.abc import Callable
from math import isfinite

from lbr.leases import rules
from lbr.leases.lease import LATE_S, LeaseRequest, confirmed
from lbr.messages.codes import Code, Reason
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand, TwistCommand
from lbr.operations.drive import distance_goal, turn_goal
from lbr.operations.drive.command import Motion, asked_sides, moves, power_of, sides_of, what
from lbr.operations.drive.goals import not_plausible
from lbr.operations.drive.limits import limit
from lbr.operations.drive.rules import Limit
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import Command, State, motors_trouble

Link = Callable[[State, Command, LeaseRequest, float], Reason | None]


def asks(event: Command, settings: DriveSettings) -> LeaseRequest:
    """Return a command as far as leases are concerned; one that the user's checks have seen may be older."""
    command = event.command
    return LeaseRequest(
        source=event.source,
        lease=command.lease,
        what=what(command),
        moves=moves(command),
        received=event.received,
        new_lease=event.new_lease,
        take_over=command.take_over,
        ttl_s=command.ttl_s,
        remote=event.remote,
        sender_s=event.sender_s,
        waited_s=event.waited_s,
        by=event.by,
        answerable=event.answerable,
        patience_s=LATE_S + (2 * settings.checks_timeout_s if event.checks else 0.0),
    )


def to_be_checked(state: State, event: Command, now: float) -> bool:
    """Say whether the user's checks are to be asked: for new and changed motion that nothing else refuses."""
    ask = asks(event, state.settings)
    if not ask.moves or rules.intent(state.leases, ask) == "renewal" or confirmed(state.leases, ask):
        return False
    return not refusal(state, event, ask, now, renewal=False, checked=False)


def refusal(
    state: State, event: Command, ask: LeaseRequest, now: float, *, renewal: bool, checked: bool = True
) -> Reason | None:
    """Return why a command is refused, or nothing; `checked` false leaves out the user's own checks.

    What is renewed was looked at before.
    """
    links = RENEWAL if renewal else CHAIN if checked else CHAIN[:-1]
    return next((why for link in links if (why := link(state, event, ask, now))), None)


def limited_by_rules(state: State, command: Motion, now: float) -> Limit:
    """Return what the rules would do to a command now, were it at its full speed."""
    return limit(state, sides_of(command, state.settings, state.base), now)


def notes(state: State, command: Motion, now: float) -> Reason | None:
    """Return what the asker of an accepted command should know: how far it is limited, and by what."""
    found: list[str] = []
    if isinstance(command, DriveCommand) and command.power > state.settings.max_power:
        found.append(f"limited to {state.settings.max_power:g}")
    if isinstance(command, TwistCommand):
        share = state.base.fitting(*asked_sides(command, state.settings), state.settings.max_power)
        if share < 1.0:
            found.append(f"limited to {share:.0%} of this twist: a motor may not get more")
    rule = limited_by_rules(state, command, now)
    if not rule.scale > 0.0:
        found.append(f"stopped by {rule.detail}")
    elif rule.scale < 1.0:
        power = power_of(command, state.settings) * rule.scale
        found.append(f"slowed to {power:.2f} by {rule.text}")
    code: Code = rule.code if rule.scale < 1.0 else "limit"
    return Reason(code, ", ".join(found)) if found else None


def _form(state: State, event: Command, ask: LeaseRequest, now: float) -> Reason | None:
    """Numbers are finite and within their bounds, as decoding saw to, and the command has not lain about."""
    command = event.command
    for name, value, low, high in _bounds(command):
        if not (isfinite(value) and low <= value <= high):
            return Reason("bad_value", f"{name} {value:g} is outside {low:g} to {high:g}")
    if isinstance(command, DriveCommand) and command.sensor not in state.sensors.singles and _means(command):
        there = ", ".join(state.sensors.singles) or "none: no row of range_sensor tells one distance"
        return Reason("unknown_name", f"sensor '{command.sensor}' is not one of {there}")
    return rules.form(state.leases, ask, now)


def _means(command: DriveCommand) -> bool:
    """Say whether a command is about its sensor: one that names none goes by a base that has no such sensor, too."""
    return command.range_cm > 0.0 or command.sensor != "forward"


def _bounds(command: Motion) -> tuple[tuple[str, float, float, float], ...]:
    """Return name, value, least and most of each number that a command asks for."""
    if isinstance(command, TurnCommand):
        return (("angle_deg", command.angle_deg, -360.0, 360.0),)
    if isinstance(command, HeadingCommand):
        return (("heading_deg", command.heading_deg, 0.0, 360.0),)
    if isinstance(command, TwistCommand):
        return (
            ("vx_mps", command.vx_mps, -10.0, 10.0),
            ("vy_mps", command.vy_mps, -10.0, 10.0),
            ("wz_rps", command.wz_rps, -20.0, 20.0),
        )
    return (
        ("power", command.power, 0.0, 1.0),
        ("angle_deg", command.angle_deg, -360.0, 360.0),
        ("range_cm", command.range_cm, 0.0, 769.0),
        ("interval_s", command.interval_s, 0.0, 3600.0),
        ("distance_cm", command.distance_cm, 0.0, 10_000.0),
    )


def _holder(state: State, event: Command, ask: LeaseRequest, now: float) -> Reason | None:
    """One holder."""
    del event
    return rules.holder(state.leases, ask, now)


def _state(state: State, event: Command, ask: LeaseRequest, now: float) -> Reason | None:
    """Nothing but standing still while the emergency stop is latched or the motors would not follow."""
    del event
    return rules.at_rest(state.leases, ask, now, motors_trouble(state, now))


def _limits(state: State, event: Command, ask: LeaseRequest, now: float) -> Reason | None:
    """Bounds make sense: a range within the sensor's reach and not there yet, a time within the longest run.

    What turns or goes a distance needs to know how it lies or how far it came.
    """
    command = event.command
    if not ask.moves:
        return None
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


def _rules(state: State, event: Command, ask: LeaseRequest, now: float) -> Reason | None:
    """A new motion towards an obstacle does not start."""
    if not ask.moves:
        return None
    found = limited_by_rules(state, event.command, now)
    return None if found.scale > 0.0 else Reason(found.code, found.detail)


def _checks(state: State, event: Command, ask: LeaseRequest, now: float) -> Reason | None:
    """The user's own checks all agree."""
    del state, ask, now
    for name, verdict in event.checks.items():
        if verdict is None:
            return Reason("check", f"check {name} did not answer")
        if not verdict.accepted:
            why = verdict.reason or "refused without a reason"
            return Reason("check", f"check {name}: {why}", cause=verdict.code)
    return None


RENEWAL: tuple[Link, ...] = (_form, _holder, _state)
CHAIN: tuple[Link, ...] = (_form, _holder, _state, _limits, _rules, _checks)
