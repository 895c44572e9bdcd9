"""What an accepted command does to the base: it begins, goes on, changes, or is offered a lease to confirm."""

from math import copysign

from msgspec.structs import replace

from lbr.leases import decide
from lbr.leases.lease import Lease, LeaseRequest, Reply, Setpoint, Stop, confirmed
from lbr.messages.drive import TwistCommand
from lbr.operations.drive import goals
from lbr.operations.drive.acceptance import asks, notes, refusal
from lbr.operations.drive.command import fitting_sides, moves, power_of, towards_deg
from lbr.operations.drive.ending import Decision, apply, halt
from lbr.operations.drive.state import ActiveMotion, Command, State
from lbr.operations.drive.wheels import next_wheels, setpoint_of, tell


def command(state: State, event: Command, now: float) -> Decision:
    """Refuse a command, or do what it wants."""
    ask = asks(event, state.settings)
    verdict, held, refused = decide.judge(
        state.leases, ask, lambda wanted: refusal(state, event, ask, now, renewal=wanted == "renewal"), now
    )
    if verdict == "stop":
        return stop(state, Stop(source=event.source, received=event.received), now)
    state = replace(state, leases=held)
    if refused:
        return state, refused
    if verdict == "renewal":
        return state, (_accept(state, event, decide.lent(held, verdict), now),)
    active = _active_motion(state, event, ask, now)
    state, said = apply(state, *decide.grant(state.leases, ask, verdict, active, now), now)
    accepted = _accept(state, event, decide.lent(state.leases, verdict), now)
    state, driven = drive(state, now) if verdict != "offer" else (state, ())
    return state, (*said, accepted, *driven)


def stop(state: State, event: Stop, now: float) -> Decision:
    """Stand still, whichever sender says so."""
    state, said = halt(state, decide.stop(state.leases, event, now), now)
    return state, (*said, decide.STOPPED)


def drive(state: State, now: float) -> Decision:
    """Say what the motors are to do now."""
    state = next_wheels(state, now)
    lease = state.lease.id if state.lease else ""
    setpoint = Setpoint(message=setpoint_of(state, lease))
    state, said = tell(state, now)
    return state, (setpoint, *said)


def _accept(state: State, event: Command, lease: Lease[ActiveMotion], now: float) -> Reply:
    reason = notes(state, event.command, now) if moves(event.command) else None
    goal = lease.motion.goal
    return decide.accepted(lease, reason, goal.goal if goal else "")


def _active_motion(state: State, event: Command, ask: LeaseRequest, now: float) -> ActiveMotion:
    """Return what the base is to be held for; what confirms an offer goes on with the goal that was offered."""
    asked, goal = event.command, None
    if goals.bounded(asked):
        offer = confirmed(state.leases, ask)
        offered = offer.motion.goal if offer is not None else None
        goal = goals.start(asked, offered.goal if offered else event.new_goal, state, now)
    turn = goal.turn if goal else None
    angle_deg = towards_deg(asked) if turn is None else copysign(90.0, turn.asked_deg)
    sides = fitting_sides(asked, state.settings, state.base) if isinstance(asked, TwistCommand) else None
    power = power_of(asked, state.settings)
    return ActiveMotion(command=asked, power=power, angle_deg=angle_deg, goal=goal, sides=sides)
