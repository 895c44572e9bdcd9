"""The decisions of drive operations, as a pure function of what is known, what happened and when."""

from math import nan

from msgspec.structs import replace

from lbr.messages.drive import DriveState, LoopStatistics
from lbr.operations.drive import bearing, goals, holding, memory, mileage, rules, travelling, turning
from lbr.operations.drive.ending import Decision, end_all, end_what_is_over
from lbr.operations.drive.freshness import INSISTING_S
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import (
    AttitudeSeen,
    Command,
    EstopChanged,
    Event,
    Goal,
    Happened,
    Insisting,
    MotorsLost,
    MotorsSeen,
    OdometrySeen,
    Outputs,
    RangesSeen,
    State,
    Stop,
    Tick,
    motors_trouble,
)

BACK = "the clock went back"


def first_state(settings: DriveSettings) -> State:
    """Return the state of a base that nobody has moved yet."""
    return State(settings=settings)


def decide(state: State, event: Event, now: float) -> Decision:
    """Return the state after an event and what is to be said; whatever is over by `now` ends before the event counts."""
    state, ended = end_what_is_over(state, now) if now >= state.clock else _lose_time(state, now)
    state, said = _handle(replace(state, clock=now), event, now)
    return state, ended + said


def drive_state(state: State, now: float, loop: LoopStatistics | None = None) -> DriveState:
    """Return what the world may know."""
    hold = state.hold
    return DriveState(
        moving=state.left != 0.0 or state.right != 0.0,
        power=hold.power if hold else 0.0,
        angle_deg=hold.angle_deg if hold else 0.0,
        left=state.left,
        right=state.right,
        holder=hold.source if hold else None,
        goal=hold.goal.goal if hold and hold.goal else None,
        limited_by=state.limited.text,
        reason=_why_at_rest(state, now),
        estop=state.estop,
        loop=loop,
    )


def _handle(state: State, event: Event, now: float) -> Decision:
    match event:
        case Command():
            decision = holding.command(state, event, now)
        case Stop():
            decision = holding.stop(state, event, now)
        case EstopChanged():
            decision = _estop(state, event, now)
        case MotorsSeen():
            decision = _motors(state, event, now)
        case MotorsLost(reason=reason):
            decision = end_what_is_over(replace(state, motors=None, motors_gone=reason, motors_lost=now), now)
        case RangesSeen():
            decision = _ranges(state, event, now)
        case AttitudeSeen():
            decision = _attitude(state, event, now)
        case OdometrySeen():
            decision = _odometry(state, event, now)
        case Tick():
            decision = holding.drive(state, now)
    return decision


def _estop(state: State, event: EstopChanged, now: float) -> Decision:
    """Latch or release; what was sent before either begins nothing any more."""
    state = replace(state, estop=event.engaged, estop_reason=event.reason, stopped=max(state.stopped, now))
    why = f"emergency stop: {event.reason or 'no reason given'}" if event.engaged else "the emergency stop was reset"
    return end_all(state, "fault", why, now)


def _motors(state: State, event: MotorsSeen, now: float) -> Decision:
    if event.arrived < state.motors_lost:
        return state, ()
    return end_what_is_over(replace(state, motors=event.motors, motors_at=_no_later(event.arrived, now)), now)


def _ranges(state: State, event: RangesSeen, now: float) -> Decision:
    arrived = _no_later(event.arrived, now)
    views = rules.see(state.views, event.ranges, arrived, state.odometer)
    state = replace(state, views=views, memory=memory.see(state.memory, views, arrived, state.settings))
    if state.hold is None or state.hold.goal is None:
        return state, ()
    goal = goals.watch(state.hold.goal, event.ranges, arrived)
    return end_what_is_over(replace(state, hold=replace(state.hold, goal=goal)), now)


def _attitude(state: State, event: AttitudeSeen, now: float) -> Decision:
    """Take in the attitude; a turn that goes on is watched by it."""
    seen = bearing.see(state.bearing, event.attitude, _no_later(event.arrived, now), state.settings)
    state = replace(state, bearing=seen, memory=memory.turned(state.memory, state.bearing, seen))
    goal = _goal(state)
    if goal is None or goal.turn is None:
        return state, ()
    turn = turning.watch(goal.turn, seen, state.left, state.settings)
    return end_what_is_over(_with_goal(state, replace(goal, turn=turn)), now)


def _odometry(state: State, event: OdometrySeen, now: float) -> Decision:
    """Take in the odometry; a distance that is being driven is watched by it."""
    seen = mileage.see(state.mileage, event.odometry, _no_later(event.arrived, now), state.settings)
    state = replace(state, mileage=seen, memory=memory.drove(state.memory, state.mileage, seen))
    goal = _goal(state)
    if state.hold is None or goal is None or goal.way is None:
        return state, ()
    way = travelling.watch(goal.way, seen, state.left, state.settings)
    said: Outputs = ()
    if seen.slipping and not way.slipped:
        way = replace(way, slipped=True)
        said = _slips(state.hold.source)
    state, ended = end_what_is_over(_with_goal(state, replace(goal, way=way)), now)
    return state, said + ended


def _slips(source: str) -> Outputs:
    text = f"{source}: the wheels slip: they turn otherwise than the base does, so the distance is not sure"
    return (Happened(kind="slip", text=text, level="warning"),)


def _goal(state: State) -> Goal | None:
    return state.hold.goal if state.hold is not None else None


def _with_goal(state: State, goal: Goal) -> State:
    return state if state.hold is None else replace(state, hold=replace(state.hold, goal=goal))


def _no_later(arrived: float, now: float) -> float:
    return min(arrived, now)  # this way round, NaN stays NaN


def _lose_time(state: State, now: float) -> Decision:
    """Stop and forget whatever has a date: none of it means anything on a clock that went back."""
    recent = {name: found for name, found in state.insisting.items() if not state.clock >= found.until}
    insisting = {name: Insisting(until=now + INSISTING_S, how=found.how) for name, found in recent.items()}
    forgotten = replace(
        state,
        motors=None,
        motors_gone=f"{BACK}; the motor driver was not heard since",
        motors_lost=now,
        views={},
        memory=memory.redated(state.memory, now),
        bearing=bearing.UNHEARD,
        mileage=mileage.UNHEARD,
        stopped=now,
        begun=now,
        insisting=insisting,
        told_at=nan,
        ticked=nan,
    )
    return end_all(forgotten, "fault", BACK, now)


def _why_at_rest(state: State, now: float) -> str:
    if state.estop:
        return f"emergency stop: {state.estop_reason or 'no reason given'}"
    if state.hold is None:
        waiting = ", ".join(offer.source for offer in state.offers)
        return motors_trouble(state, now) or (f"waiting for {waiting} to confirm" if waiting else state.reason)
    return "" if state.limited.scale > 0.0 else f"stopped by {state.limited.detail}"
