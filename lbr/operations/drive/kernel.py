"""The decisions of drive operations, as a pure function of state, event and time."""

from collections.abc import Iterable
from math import inf, isfinite, isnan

from msgspec.structs import replace

from lbr.leases import decide as leasing
from lbr.leases import ending
from lbr.leases.lease import EstopChanged, Happened, Phrasing, Stop, first
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveState, LoopStatistics
from lbr.messages.kinematics import Base, differential
from lbr.messages.sensing import RangeSensor
from lbr.operations.drive import (
    distance_goal,
    goals,
    granting,
    heading_view,
    obstacle_memory,
    odometry_view,
    rules,
    turn_goal,
)
from lbr.operations.drive.ending import Decision, end_what_is_over, halt
from lbr.operations.drive.sensors import sensors_of
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import (
    AttitudeSeen,
    Command,
    Event,
    Goal,
    MotorsLost,
    MotorsSeen,
    OdometrySeen,
    Outputs,
    RangesSeen,
    ScanSeen,
    State,
    Tick,
    motors_trouble,
)

PHRASING = Phrasing(noun="the base", rest="send power 0, or pause, before driving again", idle="no sender drives")
LAPSE_AHEAD_ROUNDS = 1.5
"""The reserve for a lapse: the loop notices it up to a round late, and it takes a moment to reach the motors."""


def first_state(
    settings: DriveSettings,
    began: float = -inf,
    sensors: Iterable[RangeSensor] | None = None,
    base: Base | None = None,
) -> State:
    """Return the state of a base that was not moved since it `began`.

    The default sensors are a ring, the default wheels two driven ones.
    """
    base = differential(settings.track_m) if base is None else base
    settings = replace(settings, track_m=base.track_m)
    ahead_s = LAPSE_AHEAD_ROUNDS / settings.rate_hz
    return State(
        settings=settings,
        sensors=sensors_of(settings, sensors),
        base=base,
        leases=first(PHRASING, settings.ttl_s, ahead_s, began=began),
    )


def decide(state: State, event: Event, now: float) -> Decision:
    """Return the state after an event, and the outputs; what is over by `now` ends before the event counts."""
    state, ended = end_what_is_over(state, now) if now >= state.clock else _lose_time(state, now)
    state, said = _handle(replace(state, clock=now), event, now)
    return state, ended + said


def drive_state(state: State, now: float, loop: LoopStatistics | None = None) -> DriveState:
    """Return the published state."""
    lease = state.lease
    goal = _goal(state)
    why = _why_at_rest(state, now)
    return DriveState(
        moving=any(side != 0.0 for side in state.sides),
        power=lease.motion.power if lease else 0.0,
        angle_deg=lease.motion.angle_deg if lease else 0.0,
        left=state.left,
        right=state.right,
        holder=lease.source if lease else None,
        goal=goal.goal if goal else None,
        limited_by=state.limited.text,
        reason=why.text if why else "",
        code=why.code if why else "",
        estop=state.leases.estop,
        loop=loop,
        stopped_s=state.leases.stopped if isfinite(state.leases.stopped) else None,
        stopped_by=state.leases.stopped_by,
        halted_s=state.leases.halts.at if isfinite(state.leases.halts.at) else None,
        halted_by=state.leases.halts.source,
        sees=_sees(state, now),
        aside=state.aside,
    )


def _handle(state: State, event: Event, now: float) -> Decision:
    match event:
        case Command():
            decision = granting.command(state, event, now)
        case Stop():
            decision = granting.stop(state, event, now)
        case EstopChanged():
            decision = halt(state, leasing.latch(state.leases, event, now), now)
        case MotorsSeen():
            decision = _motors(state, event, now)
        case MotorsLost(reason=reason):
            decision = end_what_is_over(replace(state, motors=None, motors_gone=reason, motors_lost=now), now)
        case RangesSeen() | ScanSeen():
            decision = _ranges(state, event, now) if isinstance(event, RangesSeen) else (_scan(state, event, now), ())
        case AttitudeSeen():
            decision = _attitude(state, event, now)
        case OdometrySeen():
            decision = _odometry(state, event, now)
        case Tick():
            decision = granting.drive(state, now)
    return decision


def _motors(state: State, event: MotorsSeen, now: float) -> Decision:
    if event.arrived < state.motors_lost:
        return state, ()
    return end_what_is_over(replace(state, motors=event.motors, motors_at=_no_later(event.arrived, now)), now)


def _ranges(state: State, event: RangesSeen, now: float) -> Decision:
    arrived = _no_later(event.arrived, now)
    readings = replace(event.ranges, rests=event.ranges.rests and state.lease is None)
    views = rules.see(state.views, readings, arrived, state.odometer, state.sensors)
    state = replace(
        state, views=views, memory=obstacle_memory.see(state.memory, views, arrived, state.settings, state.sensors)
    )
    goal = _goal(state)
    if goal is None:
        return state, ()
    return end_what_is_over(
        _with_goal(state, goals.watch(goal, event.ranges, arrived, state.ahead_mps(now), state.sensors)), now
    )


def _scan(state: State, event: ScanSeen, now: float) -> State:
    """Add a scan; it is ignored if its sensor has no row, or a row with one distance."""
    scan, arrived = event.scan, _no_later(event.arrived, now)
    row = state.sensors.rows.get(scan.sensor)
    if row is None or row.rays == 1:
        return state
    before = state.scans.get(scan.sensor)
    same = before is not None and before.ranges_m == scan.ranges_m and any(isinstance(m, float) for m in scan.ranges_m)
    views = rules.see_scan(state.views, scan, arrived, state.odometer, state.sensors, same=same)
    remembered = obstacle_memory.see_scan(state.memory, row, scan, arrived, state.settings)
    return replace(state, views=views, scans={**state.scans, scan.sensor: scan}, memory=remembered)


def _sees(state: State, now: float) -> dict[str, float | None]:
    """Return the distances in the way that sensors with a view of their own see; without an obstacle they are left
    out."""
    seen, watched = state.seen(now), state.sensors.watched
    believed = {name: rules.believed(seen.get(name), rule, now)[0] for name, rule in watched.items()}
    return {
        name: None if isnan(near_m) else round(near_m, 3)
        for name, near_m in believed.items()
        if near_m < inf or isnan(near_m)
    }


def _attitude(state: State, event: AttitudeSeen, now: float) -> Decision:
    """Update the attitude; a turn in progress is checked by it."""
    seen = heading_view.see(state.heading, event.attitude, _no_later(event.arrived, now), state.settings)
    state = replace(state, heading=seen, memory=obstacle_memory.turned(state.memory, state.heading, seen))
    goal = _goal(state)
    if goal is None or goal.turn is None:
        return state, ()
    turn = turn_goal.watch(goal.turn, seen, state.left, state.settings)
    return end_what_is_over(_with_goal(state, replace(goal, turn=turn)), now)


def _odometry(state: State, event: OdometrySeen, now: float) -> Decision:
    """Update the odometry; a distance in progress is checked by it."""
    seen = odometry_view.see(state.odometry, event.odometry, _no_later(event.arrived, now), state.settings)
    state = replace(state, odometry=seen, memory=obstacle_memory.drove(state.memory, state.odometry, seen))
    goal = _goal(state)
    if state.lease is None or goal is None or goal.way is None:
        return state, ()
    way = distance_goal.watch(goal.way, seen, state.left, state.settings)
    slip: Outputs = ()
    if seen.slipping and not way.slipped:
        way = replace(way, slipped=True)
        slip = _slips(state.lease.source)
    state, ended = end_what_is_over(_with_goal(state, replace(goal, way=way)), now)
    return state, slip + ended


def _slips(source: str) -> Outputs:
    text = f"{source}: the wheels slip: they turn otherwise than the base does, so the distance is not sure"
    return (Happened(kind="slip", text=text, level="warning", code="not_followed", about=source),)


def _goal(state: State) -> Goal | None:
    return state.lease.motion.goal if state.lease is not None else None


def _with_goal(state: State, goal: Goal) -> State:
    assert state.lease is not None, "a goal is that of a lease"
    return replace(state, leases=leasing.with_motion(state.leases, replace(state.lease.motion, goal=goal)))


def _no_later(arrived: float, now: float) -> float:
    return min(arrived, now)  # this way round, NaN stays NaN


def _lose_time(state: State, now: float) -> Decision:
    """Stop, and forget every dated value: dates are meaningless after the clock went back."""
    forgotten = replace(
        state,
        motors=None,
        motors_gone=f"{ending.BACK}; the motor driver has not reported since",
        motors_lost=now,
        views={},
        memory=obstacle_memory.redated(state.memory, now),
        heading=heading_view.UNKNOWN,
        odometry=odometry_view.UNKNOWN,
    )
    return halt(forgotten, ending.lose_time(state.leases, state.clock, now), now)


def _why_at_rest(state: State, now: float) -> Reason | None:
    held = state.leases
    if held.estop:
        return Reason("estop", f"emergency stop: {held.estop_reason or 'no reason given'}")
    if state.lease is None:
        if trouble := motors_trouble(state, now):
            return trouble
        waiting = ", ".join(offer.source for offer in held.offers)
        return Reason("not_ready", f"waiting for {waiting} to confirm") if waiting else held.reason
    return None if state.limited.scale > 0.0 else Reason(state.limited.code, f"stopped by {state.limited.detail}")
