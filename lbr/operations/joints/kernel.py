"""The decisions of joints operation, as a pure function of state, event and time."""

from math import nan

from msgspec.structs import replace

from lbr.leases import decide as leasing
from lbr.leases import ending
from lbr.leases.ask import Ask
from lbr.leases.lease import Ended, EstopChanged, Reply, Stop
from lbr.messages.codes import Reason
from lbr.operations.joints import feet, moving, planning, servos, stored, torque
from lbr.operations.joints.acceptance import asked_of, command_of, refusal
from lbr.operations.joints.ending import Decision, end_what_is_over, setpoint, still, take
from lbr.operations.joints.move import Move
from lbr.operations.joints.request import strengths
from lbr.operations.joints.state import Command, Event, HolderGone, ServosLost, ServosSeen, State, Tick, Torque, waits


def decide(state: State, event: Event, now: float) -> Decision:
    """Return the state after an event, and the outputs; what is over by `now` ends before the event counts."""
    state, ended = end_what_is_over(state, now) if now >= state.clock else _lose_time(state, now)
    state, said = _handle(servos.expired(replace(state, clock=now), now), event, now)
    return state, ended + said


def _handle(state: State, event: Event, now: float) -> Decision:
    match event:
        case Command():
            decision = _command(state, event, now)
        case Torque():
            decision = torque.switch(moving.advance(state, now), event, now)
        case Stop():
            state, said = still(state, leasing.stop(state.leases, event, now), now, event)
            decision = state, (*said, feet.reply(state, now))
        case HolderGone():
            decision = _holder_gone(state, event, now)
        case EstopChanged():
            decision = still(state, leasing.latch(state.leases, event, now), now)
        case ServosSeen():
            decision = servos.seen(state, event, now)
        case ServosLost():
            decision = servos.driver_lost(state, event, now)
        case Tick():
            state, ended = end_what_is_over(moving.advance(feet.advance(state, now), now), now)
            decision = state, (*ended, *setpoint(state))
    return decision


def _command(state: State, event: Command, now: float) -> Decision:
    """Refuse a command, or do it."""
    ask = asked_of(state, event, now)
    if why := refusal(state, ask):
        held, refused = leasing.refuse(ask, why)
        return replace(state, leases=held), (refused,)
    match ask.wants:
        case "renewal":
            state = replace(state, leases=leasing.renew(ask))
            return state, (_yes(state, ask),)
        case "offer":
            offer = Move(goal=event.new_goal, begun=now)
            state, said = take(state, leasing.grant(state.leases, ask, offer), now)
            made = leasing.lent(state.leases, ask)
            return state, (*said, leasing.accepted(made, goal=made.motion.goal))
        case "change":
            return _change(state, event, ask, now)
    return _begin(state, event, ask, now)


def _begin(state: State, event: Command, ask: Ask[Move], now: float) -> Decision:
    """Grant the joints; the confirmation of an offer keeps the offered goal."""
    idle_s, state = _idle_s(state, now), moving.advance(state, now)
    state = moving.interrupted(moving.held_again(state))
    state, torque_events = _strengthened(state, event, ask, now)
    offer = ask.confirms
    state, move = _move(state, ask, offer.motion.goal if offer else event.new_goal, idle_s, now)
    state, said = take(state, leasing.grant(state.leases, ask, move), now)
    state = _underway(state)
    return state, (*torque_events, *said, _yes(state, ask), *setpoint(state))


def _change(state: State, event: Command, ask: Ask[Move], now: float) -> Decision:
    """Change the motion under the same lease, from the next setpoint on; appended or joined motion keeps its goal."""
    idle_s, state = _idle_s(state, now), moving.advance(state, now)
    state, torque_events = _strengthened(state, event, ask, now)
    command, move = command_of(ask), state.move
    assert move is not None
    if command.append or command.join:
        if command.append:
            longer = planning.append(state, move, command, now)
        else:
            longer = planning.joined(state, move, command, now, idle_s)
        leases, outputs = leasing.grant(state.leases, ask, longer)
        outputs = tuple(each for each in outputs if not isinstance(each, Ended))
    else:
        state, anew = _move(state, ask, event.new_goal, idle_s, now)
        leases, outputs = leasing.grant(state.leases, ask, planning.instead(move, anew))
    state, reports = take(state, (leases, outputs), now)
    state = _underway(state)
    at_once = setpoint(state) if command.join else ()
    return state, (*torque_events, *reports, _yes(state, ask), *at_once)


def _move(state: State, ask: Ask[Move], goal: str, idle_s: float, now: float) -> tuple[State, Move]:
    command = command_of(ask)
    if command.stored is not None:
        return stored.begin(state, command.stored, goal, now)
    return state, planning.begin(state, command, goal, now, idle_s)


def _strengthened(state: State, event: Command, ask: Ask[Move], now: float) -> Decision:
    strong = strengths(command_of(ask), state.body)
    return torque.strengthen(state, event.source, strong, now) if strong else (state, ())


def _underway(state: State) -> State:
    """Return the state in which joined joints move with this setpoint, not the next."""
    assert state.move is not None
    return replace(state, goals={**state.goals, **state.move.positions()})


def _idle_s(state: State, now: float) -> float:
    """Return the time since the joints' positions were last computed, a period at most: at rest rounds are rare."""
    return 0.0 if waits(state) else min(max(0.0, now - state.ticked), 1.0 / state.settings.rate_hz)


def _yes(state: State, ask: Ask[Move]) -> Reply:
    move = state.move
    assert move is not None
    note = planning.note(state, move, command_of(ask))
    return leasing.accepted(leasing.lent(state.leases, ask), Reason("limit", note) if note else None, move.goal)


def _holder_gone(state: State, event: HolderGone, now: float) -> Decision:
    """End the motion of a lost holder; it can no longer confirm an offer."""
    lease, why = state.leases.live, Reason("holder_gone", f"the process of {event.source} is gone")
    if lease is None or lease.source != event.source:
        return state, ()
    return take(state, ending.end(state.leases, "lapsed", why, now), now, at_once=True)


def _lose_time(state: State, now: float) -> Decision:
    """Stop, and forget every dated value: dates are meaningless after the clock went back."""
    gone = f"{ending.BACK}; the servo driver has not reported since"
    state, said = still(state, ending.lose_time(state.leases, state.clock, now), now)
    return replace(state, servos=None, servos_gone=gone, servos_lost=now, servos_at=nan), said
