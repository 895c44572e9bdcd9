"""The decisions of drive operations, as a pure function of what is known, what happened and when."""

from math import isnan, nan

from msgspec.structs import replace

from lbr.messages.drive import CommandReply, DriveState, LoopStatistics
from lbr.messages.motors import MotorSetpoint
from lbr.operations.drive import goals, rules
from lbr.operations.drive.acceptance import INSISTING_S, insists, intent, notes, refusal
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import (
    Command,
    Ending,
    EstopChanged,
    Event,
    Goal,
    Happened,
    Hold,
    Level,
    MotorsLost,
    MotorsSeen,
    Outputs,
    RangesSeen,
    Reply,
    Result,
    Setpoint,
    State,
    Stop,
    Tick,
    bury,
    motors_trouble,
)
from lbr.operations.drive.wheels import next_wheels, tell

Decision = tuple[State, Outputs]
ZERO = Setpoint(message=MotorSetpoint(left=0.0, right=0.0))
UNPLANNED = ("lapsed", "fault")
LAPSE_AHEAD_ROUNDS = 1.5
"""A lapse is noticed by the loop, up to a round late, and takes a moment to reach the motors."""


def first_state(settings: DriveSettings) -> State:
    """Return the state of a base that nobody has moved yet."""
    return State(settings=settings)


def decide(state: State, event: Event, now: float) -> Decision:
    """Return the state after an event and what is to be said; whatever is over by `now` ends before the event counts."""
    state, ended = _end_what_is_over(state, now)
    state, said = _handle(state, event, now)
    return state, ended + said


def drive_state(state: State, now: float, loop: LoopStatistics | None = None) -> DriveState:
    """Return what the world may know."""
    hold = state.hold
    return DriveState(
        moving=state.left != 0.0 or state.right != 0.0,
        power=hold.power if hold else 0.0,
        angle_deg=hold.command.angle_deg if hold else 0.0,
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
            decision = _command(state, event, now)
        case Stop():
            decision = _stop(state, event, now)
        case EstopChanged():
            decision = _estop(state, event, now)
        case MotorsSeen(motors=motors, arrived=arrived):
            decision = _end_what_is_over(replace(state, motors=motors, motors_at=arrived), now)
        case MotorsLost(reason=reason):
            decision = _end_what_is_over(replace(state, motors=None, motors_gone=reason), now)
        case RangesSeen():
            decision = _ranges(state, event, now)
        case Tick():
            decision = _drive(state, now)
    return decision


def _command(state: State, event: Command, now: float) -> Decision:
    wanted = intent(state, event.command)
    if wanted == "stop":
        return _stop(state, Stop(source=event.source, received=event.received), now)
    if why := refusal(state, event, now):
        return _refuse(state, event, why, now)
    if wanted == "renewal":
        return _renew(state, event, now)
    return _change(state, event, now) if wanted == "change" else _begin(state, event, now)


def _refuse(state: State, event: Command, why: str, now: float) -> Decision:
    reply = Reply(message=CommandReply(accepted=False, reason=why), late=bool(event.command.lease))
    if event.command.power > 0.0 and (state.estop or insists(state, event.source, now)):
        state = _note_insisting(state, event.source, now)
    return state, (reply,)


def _renew(state: State, event: Command, now: float) -> Decision:
    assert state.hold is not None
    return _accept(state, replace(state.hold, ttl_s=_ttl_s(state, event)), event, now)


def _change(state: State, event: Command, now: float) -> Decision:
    assert state.hold is not None
    goal = state.hold.goal
    said: Outputs = () if goal is None else (_result(goal, "superseded", "another command came", now),)
    hold = _new_hold(state, event, state.hold.lease, now)
    state, accepted = _accept(state, hold, event, now)
    state, driven = _drive(state, now)
    return state, said + accepted + driven


def _begin(state: State, event: Command, now: float) -> Decision:
    state, ended = _end(state, "superseded", f"taken over by {event.source}", now) if state.hold else (state, ())
    state, accepted = _accept(state, _new_hold(state, event, event.new_lease, now), event, now)
    state, driven = _drive(state, now)
    return state, ended + accepted + driven


def _accept(state: State, hold: Hold, event: Command, now: float) -> Decision:
    hold = replace(hold, expires=now + hold.ttl_s - _ahead_s(state, hold.ttl_s))
    reply = CommandReply(
        accepted=True,
        reason=notes(state, event.command, now) if event.command.power > 0.0 else "",
        lease=hold.lease,
        ttl_s=hold.ttl_s,
        goal=hold.goal.goal if hold.goal else "",
    )
    return replace(state, hold=hold, reason=""), (Reply(message=reply),)


def _new_hold(state: State, event: Command, lease: str, now: float) -> Hold:
    command = event.command
    goal = goals.start(command, event.new_goal, state.views, state.settings, now) if goals.bounded(command) else None
    return Hold(
        lease=lease,
        source=event.source,
        command=command,
        power=min(command.power, state.settings.max_power),
        ttl_s=_ttl_s(state, event),
        expires=nan,
        changed=now,
        goal=goal,
    )


def _ahead_s(state: State, ttl_s: float) -> float:
    """Return how much sooner a lease is over, so that the wheels stand, at the loop's pace, within the time it gave."""
    return min(LAPSE_AHEAD_ROUNDS / state.settings.rate_hz, ttl_s / 5)


def _ttl_s(state: State, event: Command) -> float:
    return state.settings.ttl_s if event.command.ttl_s is None else event.command.ttl_s


def _stop(state: State, event: Stop, now: float) -> Decision:
    stopped = max(state.stopped, event.received)
    state = _forget_insisting(replace(state, stopped=stopped), event.source)
    why = f"stopped by {event.source}" + (f": {event.reason}" if event.reason else "")
    state, said = _end(state, "stopped", why, now)
    return state, (*said, Reply(message=CommandReply(accepted=True, reason="stopped")))


def _estop(state: State, event: EstopChanged, now: float) -> Decision:
    stopped = max(state.stopped, now) if event.engaged else state.stopped
    state = replace(state, estop=event.engaged, estop_reason=event.reason, stopped=stopped)
    why = f"emergency stop: {event.reason or 'no reason given'}" if event.engaged else "the emergency stop was reset"
    return _end(state, "fault", why, now)


def _ranges(state: State, event: RangesSeen, now: float) -> Decision:
    state = replace(state, views=rules.see(state.views, event.ranges, event.arrived, state.odometer))
    if state.hold is None or state.hold.goal is None:
        return state, ()
    goal = goals.watch(state.hold.goal, event.ranges, event.arrived)
    return _end_what_is_over(replace(state, hold=replace(state.hold, goal=goal)), now)


def _drive(state: State, now: float) -> Decision:
    state = next_wheels(state, now)
    lease = state.hold.lease if state.hold else ""
    setpoint = Setpoint(message=MotorSetpoint(left=state.left, right=state.right, lease=lease))
    state, said = tell(state, now)
    return state, (setpoint, *said)


def _end_what_is_over(state: State, now: float) -> Decision:
    over = _what_is_over(state, now)
    return (state, ()) if over is None else _end(state, *over, now)


def _what_is_over(state: State, now: float) -> tuple[Ending, str] | None:
    """Return how the hold ends by itself and why, or None while it lives; comparisons are such that NaN ends it."""
    hold = state.hold
    if hold is None:
        return None
    if trouble := motors_trouble(state, now):
        return "fault", trouble
    if not now < hold.expires:
        return "lapsed", f"it lapsed, not renewed within {hold.ttl_s:g} s"
    if hold.goal is not None and (ended := goals.ending(hold.goal, now)):
        return ended
    worn = _worn_out(state, hold, now) if hold.command.power > 0.0 else ""
    return ("stopped", worn) if worn else None


def _worn_out(state: State, hold: Hold, now: float) -> str:
    """Return why a motion that nobody ended is over: it ran unattended, or a rule has held the base still."""
    settings = state.settings
    if not now - hold.changed < settings.max_run_s:
        return f"it ran for {settings.max_run_s:g} s unattended"
    if not isnan(state.blocked_since) and not now - state.blocked_since < settings.blocked_s:
        return f"held still for {settings.blocked_s:g} s: {state.limited.detail}"
    return ""


def _end(state: State, how: Ending, why: str, now: float) -> Decision:
    """Stand still at once; whoever held the base does so no more, and is told why."""
    hold = state.hold
    still = next_wheels(replace(state, hold=None), now)
    if hold is None:
        return replace(still, reason=why), (ZERO,)
    level: Level = "warning" if how in UNPLANNED else "info"
    said: Outputs = (ZERO, Happened(kind=how, text=f"{hold.source}: {why}", level=level))
    if hold.goal is not None:
        said = (*said, _result(hold.goal, how, why, now))
    return bury(still, hold.lease, why), said


def _result(goal: Goal, how: Ending, why: str, now: float) -> Result:
    return Result(message=goals.result(goal, how, why, now))


def _note_insisting(state: State, source: str, now: float) -> State:
    """Remember who goes on sending through an emergency stop, so that its reset by itself moves nothing."""
    recent = {name: at for name, at in state.insisting.items() if now - at < INSISTING_S}
    return replace(state, insisting={**recent, source: now})


def _forget_insisting(state: State, source: str) -> State:
    return replace(state, insisting={name: at for name, at in state.insisting.items() if name != source})


def _why_at_rest(state: State, now: float) -> str:
    if state.estop:
        return f"emergency stop: {state.estop_reason or 'no reason given'}"
    if state.hold is None:
        return motors_trouble(state, now) or state.reason
    return "" if state.limited.scale > 0.0 else f"stopped by {state.limited.detail}"
