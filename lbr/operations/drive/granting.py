"""The effect of a command: a refusal, a renewal, a change, a new motion, or an offer of a lease to confirm."""

from math import copysign

from msgspec.structs import replace

from lbr.leases import decide
from lbr.leases.ask import Ask, resolve
from lbr.leases.lease import LATE_S, LeaseRequest, LeaseTable, Reply, Setpoint, Stop
from lbr.messages.codes import Code, Reason
from lbr.messages.drive import DriveCommand, TwistCommand
from lbr.operations.drive import goals
from lbr.operations.drive.acceptance import judge
from lbr.operations.drive.command import Motion, asked_sides, content_of, fitting_sides, moves, power_of, towards_deg
from lbr.operations.drive.ending import Decision, apply, halt
from lbr.operations.drive.rules import Limit
from lbr.operations.drive.state import ActiveMotion, Command, State
from lbr.operations.drive.wheels import next_wheels, setpoint_of, tell


def command(state: State, event: Command, now: float) -> Decision:
    """Refuse a command, or do it."""
    ask = _asked(state, event, now)
    if ask.wants == "stop":
        return stop(state, Stop(source=event.source, received=event.received), now)
    before, state = state, replace(state, views=state.seen(now))
    limit = judge(state, event, ask)
    if isinstance(limit, Reason):
        leases, refused = decide.refuse(ask, limit)
        return replace(before, leases=leases), (refused,)
    note = _note(state, event.command, limit)
    if ask.wants == "renewal":
        state = replace(state, leases=decide.renew(ask))
        return state, (_accepted(state.leases, ask, note),)
    state, said = apply(state, *decide.grant(state.leases, ask, _active_motion(state, event, ask)), now)
    accepted = _accepted(state.leases, ask, note)
    state, driven = drive(state, now) if ask.wants != "offer" else (replace(state, views=before.views), ())
    return state, (*said, accepted, *driven)


def to_be_checked(state: State, event: Command, now: float) -> bool:
    """Return whether the user's checks are needed: for new or changed motion that no other check refuses."""
    ask = _asked(state, event, now)
    if not ask.request.moves or ask.wants == "renewal" or ask.confirms is not None:
        return False
    return not isinstance(judge(replace(state, views=state.seen(now)), event, ask), Reason)


def stop(state: State, event: Stop, now: float) -> Decision:
    """Stop, for any sender."""
    state, said = halt(state, decide.stop(state.leases, event, now), now)
    return state, (*said, decide.STOPPED)


def drive(state: State, now: float) -> Decision:
    """Return the next setpoint of the motors."""
    state = next_wheels(state, now)
    lease = state.lease.id if state.lease else ""
    setpoint = Setpoint(message=setpoint_of(state, lease))
    state, said = tell(state, now)
    return state, (setpoint, *said)


def _asked(state: State, event: Command, now: float) -> Ask[ActiveMotion]:
    """Return a command as a request to the leases; after the user's checks it may be older."""
    command = event.command
    request = LeaseRequest(
        **event.origin(),
        lease=command.lease,
        content=content_of(command),
        moves=moves(command),
        take_over=command.take_over,
        ttl_s=command.ttl_s,
        patience_s=LATE_S + (2 * state.settings.checks_timeout_s if event.checks else 0.0),
    )
    return resolve(state.leases, request, now)


def _active_motion(state: State, event: Command, ask: Ask[ActiveMotion]) -> ActiveMotion:
    """Return the motion of the base; the confirmation of an offer keeps the offered goal."""
    asked, goal = event.command, None
    if goals.bounded(asked):
        offered = ask.confirms.motion.goal if ask.confirms is not None else None
        goal = goals.start(asked, offered.goal if offered else event.new_goal, state, ask.now)
    turn = goal.turn if goal else None
    angle_deg = towards_deg(asked) if turn is None else copysign(90.0, turn.asked_deg)
    sides = fitting_sides(asked, state.settings, state.base) if isinstance(asked, TwistCommand) else None
    power = power_of(asked, state.settings)
    return ActiveMotion(command=asked, power=power, angle_deg=angle_deg, goal=goal, sides=sides)


def _accepted(leases: LeaseTable[ActiveMotion], ask: Ask[ActiveMotion], note: Reason | None) -> Reply:
    lease = decide.lent(leases, ask)
    goal = lease.motion.goal
    return decide.accepted(lease, note, goal.goal if goal else "")


def _note(state: State, command: Motion, limit: Limit) -> Reason | None:
    """Return a note for the sender of an accepted command: its limit, and the cause; None without one."""
    notes: list[str] = []
    if isinstance(command, DriveCommand) and command.power > state.settings.max_power:
        notes.append(f"limited to {state.settings.max_power:g}")
    if isinstance(command, TwistCommand):
        share = state.base.fitting(*asked_sides(command, state.settings), state.settings.max_power)
        if share < 1.0:
            notes.append(f"limited to {share:.0%} of this twist: a motor may not get more")
    if not limit.scale > 0.0:
        notes.append(f"stopped by {limit.detail}")
    elif limit.scale < 1.0:
        power = power_of(command, state.settings) * limit.scale
        notes.append(f"slowed to {power:.2f} by {limit.text}")
    code: Code = limit.code if limit.scale < 1.0 else "limit"
    return Reason(code, ", ".join(notes)) if notes else None
