"""Kernels broken on purpose: each does one thing that must never be, and has to be found out."""

from collections.abc import Callable
from math import inf, isfinite

from msgspec.structs import replace

from lbr.leases.decide import with_motion
from lbr.leases.lease import EstopChanged, Stop
from lbr.messages.drive import HeadingCommand
from lbr.operations.drive import kernel
from lbr.operations.drive.state import (
    AttitudeSeen,
    Command,
    Event,
    OdometrySeen,
    Outputs,
    RangesSeen,
    State,
    Tick,
)
from tests.models.motion.arena import Decide

Decision = tuple[State, Outputs]


def no_lapse(state: State, event: Event, now: float) -> Decision:
    """Leases live for ever."""
    if state.lease is not None:
        state = replace(state, leases=replace(state.leases, live=replace(state.lease, expires=inf)))
    return kernel.decide(state, event, now)


def resumes_after_reset(state: State, event: Event, now: float) -> Decision:
    """Goes on, when the emergency stop is reset, with what was held before it."""
    after, said = kernel.decide(state, event, now)
    if isinstance(event, EstopChanged):
        leases = replace(after.leases, live=state.leases.live, revoked=state.leases.revoked)
        after = replace(after, leases=leases)
    return after, said


def ignores_estop(state: State, event: Event, now: float) -> Decision:
    """Hears no emergency stop."""
    if isinstance(event, EstopChanged):
        return kernel.decide(state, replace(event, engaged=False), now)
    return kernel.decide(state, event, now)


def ignores_holder(state: State, event: Event, now: float) -> Decision:
    """Lets everybody take over."""
    if isinstance(event, Command):
        event = replace(event, command=replace(event.command, take_over=True))
    return kernel.decide(state, event, now)


def passes_nan(state: State, event: Event, now: float) -> Decision:
    """Takes an unknown distance for a free way."""
    if isinstance(event, RangesSeen):
        status = {side: "over_range" if what == "missing" else what for side, what in event.ranges.status.items()}
        event = replace(event, ranges=replace(event.ranges, status=status))
    return kernel.decide(state, event, now)


def ignores_a_broken_clock(state: State, event: Event, now: float) -> Decision:
    """Goes on by the last good time when the clock makes no sense."""
    good = state.clock if isfinite(state.clock) and not now >= state.clock else now
    return kernel.decide(state, event, good)


def believes_old_commands(state: State, event: Event, now: float) -> Decision:
    """Takes whatever arrives for new."""
    if isinstance(event, Command):
        event = replace(event, received=now, sender_s=now)
    return kernel.decide(state, event, now)


def trusts_afar(state: State, event: Event, now: float) -> Decision:
    """Needs no proof from other machines."""
    return kernel.decide(state, replace(event, remote=False) if isinstance(event, Command) else event, now)


def forgets_stops(state: State, event: Event, now: float) -> Decision:
    """Stops, and lets what was sent before that begin again."""
    after, said = kernel.decide(state, event, now)
    forgotten = replace(after, leases=replace(after.leases, stopped=-inf))
    return (forgotten if isinstance(event, Stop) else after), said


def jumps_to_speed(state: State, event: Event, now: float) -> Decision:
    """Knows no limit of growth."""
    settings = replace(state.settings, accel_per_s=50.0)
    after, said = kernel.decide(replace(state, settings=settings), event, now)
    return replace(after, settings=state.settings), said


def believes_any_attitude(state: State, event: Event, now: float) -> Decision:
    """Takes every attitude for valid, and for the one it has known."""
    if isinstance(event, AttitudeSeen):
        event = replace(event, attitude=replace(event.attitude, valid=True, epoch="a"))
    return kernel.decide(state, event, now)


def misses_no_attitude(state: State, event: Event, now: float) -> Decision:
    """Turns on by the last attitude, however old."""
    course = state.lease.motion if isinstance(event, Tick) and state.lease else None
    if course and course.goal and course.goal.turn:
        turn = course.goal.turn
        goal = replace(course.goal, turn=replace(turn, heading=replace(turn.heading, seen=now)))
        state = replace(state, leases=with_motion(state.leases, replace(course, goal=goal)))
    return kernel.decide(state, event, now)


def turns_at_full_power(state: State, event: Event, now: float) -> Decision:
    """Knows no limit for turns."""
    after, said = kernel.decide(replace(state, settings=replace(state.settings, turn_power=0.8)), event, now)
    return replace(after, settings=state.settings), said


def turns_the_longer_way(state: State, event: Event, now: float) -> Decision:
    """Looks for headings on the other side."""
    if isinstance(event, Command) and isinstance(event.command, HeadingCommand):
        heading_deg = 360.0 - event.command.heading_deg
        event = replace(event, command=replace(event.command, heading_deg=heading_deg))
    return kernel.decide(state, event, now)


def pushes_stalled_wheels(state: State, event: Event, now: float) -> Decision:
    """Does not look whether the wheels turn."""
    if isinstance(event, OdometrySeen):
        event = replace(event, odometry=replace(event.odometry, stalled=False))
    return kernel.decide(state, event, now)


KERNELS: tuple[Callable[[State, Event, float], Decision], ...] = (
    no_lapse,
    resumes_after_reset,
    ignores_estop,
    ignores_holder,
    passes_nan,
    ignores_a_broken_clock,
    believes_old_commands,
    trusts_afar,
    forgets_stops,
    jumps_to_speed,
    believes_any_attitude,
    misses_no_attitude,
    turns_at_full_power,
    turns_the_longer_way,
    pushes_stalled_wheels,
)


def named(name: str) -> Decide:
    """Return one of them, or the real kernel for an empty name."""
    return next((broken for broken in KERNELS if broken.__name__ == name), kernel.decide)
