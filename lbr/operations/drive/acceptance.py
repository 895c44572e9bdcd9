"""The chain a drive command passes before it moves anything; the first link that objects refuses it."""

from collections.abc import Callable
from math import isfinite, isnan
from typing import Literal

from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.leases import DEAD_LEASE
from lbr.operations.drive import travelling, turning
from lbr.operations.drive.asked import Motion, moves, power_of, towards_deg, what
from lbr.operations.drive.freshness import TWICE, dated, insists, not_fresh, quoted
from lbr.operations.drive.goals import not_plausible
from lbr.operations.drive.limits import limit
from lbr.operations.drive.mixing import mix
from lbr.operations.drive.rules import SENSORS, Limit
from lbr.operations.drive.state import Command, Hold, State, motors_trouble, offered, why_dead

Intent = Literal["stop", "new", "confirmation", "renewal", "change"]
Link = Callable[[State, Command, float], str]


def intent(state: State, command: Motion) -> Intent:
    """Return what a command wants of this state: power 0 without a lease is a stop, by whomever."""
    if not moves(command) and not command.lease:
        return "stop"
    if state.hold is None or command.lease != state.hold.lease:
        return "new" if offered(state, command.lease) is None else "confirmation"
    return "renewal" if what(command) == what(state.hold.command) else "change"


def to_be_checked(state: State, event: Command, now: float) -> bool:
    """Say whether the user's checks are to be asked: for new and changed motion that nothing else refuses."""
    new = moves(event.command) and not _as_checked(state, event.command)
    return new and not refusal(state, event, now, checked=False)


def refusal(state: State, event: Command, now: float, *, checked: bool = True) -> str:
    """Return why a command is refused, or nothing; `checked` false leaves out the user's own checks."""
    links = CHAIN if checked else CHAIN[:-1]
    return next((why for link in links if (why := link(state, event, now))), "")


def streams(hold: Hold, event: Command) -> bool:
    """Say whether a sender asks anew, and has never quoted the lease that it holds the base by."""
    return hold.source == event.source and isnan(hold.renewed) and not event.command.lease


def limited_by_rules(state: State, command: Motion, now: float) -> Limit:
    """Return what the rules would do to a command now, were it at its full speed."""
    wheels = mix(power_of(command, state.settings), towards_deg(command), state.settings)
    return limit(state, wheels, now)


def notes(state: State, command: Motion, now: float) -> str:
    """Return what the asker of an accepted command should know: how far it is limited, and by what."""
    found = []
    if isinstance(command, DriveCommand) and command.power > state.settings.max_power:
        found.append(f"limited to {state.settings.max_power:g}")
    rule = limited_by_rules(state, command, now)
    if not rule.scale > 0.0:
        found.append(f"stopped by {rule.detail}")
    elif rule.scale < 1.0:
        power = power_of(command, state.settings) * rule.scale
        found.append(f"slowed to {power:.2f} by {rule.text}")
    return ", ".join(found)


def _as_checked(state: State, command: Motion) -> bool:
    """Say whether a command goes on with, or confirms, exactly what the checks have seen."""
    wanted, offer = intent(state, command), offered(state, command.lease)
    return wanted == "renewal" or (offer is not None and what(offer.command) == what(command))


def _form(state: State, event: Command, now: float) -> str:
    """Numbers are finite and within their bounds, as decoding saw to, and the command has not lain about."""
    command = event.command
    for name, value, low, high in (*_bounds(command), ("ttl_s", command.ttl_s or 0.0, 0.0, 1.0)):
        if not (isfinite(value) and low <= value <= high):
            return f"{name} {value:g} is outside {low:g} to {high:g}"
    if command.ttl_s == 0.0:
        return "ttl_s 0 is no life; leave it out or give up to 1"
    if isinstance(command, DriveCommand) and command.sensor not in SENSORS:
        return f"sensor '{command.sensor}' is none of {', '.join(SENSORS)}"
    return not_fresh(state, event, now)


def _bounds(command: Motion) -> tuple[tuple[str, float, float, float], ...]:
    """Return name, value, least and most of each number that a command asks for."""
    if isinstance(command, TurnCommand):
        return (("angle_deg", command.angle_deg, -360.0, 360.0),)
    if isinstance(command, HeadingCommand):
        return (("heading_deg", command.heading_deg, 0.0, 360.0),)
    return (
        ("power", command.power, 0.0, 1.0),
        ("angle_deg", command.angle_deg, -360.0, 360.0),
        ("range_cm", command.range_cm, 0.0, 769.0),
        ("interval_s", command.interval_s, 0.0, 3600.0),
        ("distance_cm", command.distance_cm, 0.0, 10_000.0),
    )


def _rights(state: State, event: Command, now: float) -> str:
    """Whoever may only look may not drive."""
    del state, now
    return "" if event.role in {"operate", "admin"} else f"role '{event.role}' may stop the robot but not drive it"


def _holder(state: State, event: Command, now: float) -> str:
    """One holder: a quoted lease must be the live one; without a lease nobody may hold the base, or it is taken over."""
    command, hold, owner = event.command, state.hold, quoted(state, event)
    if command.lease and not (owner is not None and now < owner.expires):  # this way round, NaN means dead
        return f"{DEAD_LEASE}{why_dead(state, command.lease)}"
    if owner is not None and (why := _not_own(owner, event)):
        return why
    if hold is not None and owner is hold:
        return _order(state, event, hold)
    takes = command.take_over or (owner is not None and owner.command.take_over)
    if hold is not None and (not takes or streams(hold, event)):
        return _held(hold, event)
    if not (state.estop or dated(state, event) > state.stopped):
        return "a stop came after this command"
    return "" if dated(state, event) > state.begun else TWICE


def _not_own(owner: Hold, event: Command) -> str:
    """A lease dates what its own sender says; another's clock proves nothing, nor does a lease that was overheard."""
    foreign = event.remote and event.source != owner.source and moves(event.command)
    return f"this lease is {owner.source}'s: ask for one of your own" if foreign else ""


def _held(hold: Hold, event: Command) -> str:
    own = ", as you do: quote the lease to go on" if hold.source == event.source else ""
    return f"held by {hold.source}{own}"


def _order(state: State, event: Command, hold: Hold) -> str:
    """What quotes a lease counts once, and not after something newer; standing still counts whenever it comes."""
    if not moves(event.command):
        return ""
    newest = max(hold.said, hold.renewed) if what(event.command) == what(hold.command) else hold.said
    return "" if dated(state, event) > newest else TWICE


def _state(state: State, event: Command, now: float) -> str:
    """Nothing but standing still while the emergency stop is latched or the motors would not follow."""
    if not moves(event.command):
        return ""
    if state.estop:
        return f"emergency stop: {state.estop_reason or 'no reason given'}; 'reset' releases it"
    if trouble := motors_trouble(state, now):
        return trouble
    how = insists(state, event.source, now)
    return f"{how}: send power 0, or pause, before driving again" if how else ""


def _limits(state: State, event: Command, now: float) -> str:
    """Bounds make sense: a range within the sensor's reach and not there yet, a time within the longest run.

    What turns or goes a distance needs to know how it lies or how far it came.
    """
    command = event.command
    if not moves(command) or intent(state, command) == "renewal":
        return ""
    if not isinstance(command, DriveCommand):
        return turning.not_possible(command, state.bearing, state.settings, now)
    if command.interval_s > state.settings.max_run_s:
        return f"interval_s {command.interval_s:g} is longer than max_run_s {state.settings.max_run_s:g}"
    why = travelling.not_possible(command, state.mileage, now)
    return why or not_plausible(command, state.views, state.settings, now)


def _rules(state: State, event: Command, now: float) -> str:
    """A new motion towards an obstacle does not start."""
    if not moves(event.command) or intent(state, event.command) == "renewal":
        return ""
    found = limited_by_rules(state, event.command, now)
    return "" if found.scale > 0.0 else found.detail


def _checks(state: State, event: Command, now: float) -> str:
    """The user's own checks all agree."""
    del state, now
    for name, verdict in event.checks.items():
        if verdict is None:
            return f"check {name} did not answer"
        if not verdict.accepted:
            return f"check {name}: {verdict.reason or 'refused without a reason'}"
    return ""


CHAIN: tuple[Link, ...] = (_form, _rights, _holder, _state, _limits, _rules, _checks)
