"""From what is held to the next setpoint: mixing, then rules, then slew, then the limit."""

from math import isnan, nan

from msgspec.structs import replace

from lbr.operations.drive import goals, obstacle_memory
from lbr.operations.drive.limits import limit
from lbr.operations.drive.rules import FREE, Limit
from lbr.operations.drive.state import Outputs, State
from lbr.operations.leasing.decide import with_motion
from lbr.operations.leasing.lease import Happened, Level

LONGEST_STEP_S = 0.1
"""Setpoints older than this move nothing, so no longer step counts."""
TELL_AGAIN_S = 1.0

Wheels = tuple[float, float]


def next_wheels(state: State, now: float) -> State:
    """Return the state with the wheels' next powers, and the base's own estimate of how far it came meanwhile."""
    elapsed_s = min(max(0.0, now - state.ticked), LONGEST_STEP_S)  # this way round, NaN is no time
    settings = state.settings
    odometer = state.odometer.driven(state.left, state.right, elapsed_s, settings.max_speed_mps)
    remembered = obstacle_memory.moved(state.memory, state.left, state.right, elapsed_s, settings)
    state = replace(state, odometer=odometer, memory=remembered, ticked=now)
    lease = state.lease
    if lease is None:
        return replace(state, left=0.0, right=0.0, limited=FREE, blocked_since=nan, told="", told_stop=False)
    active = lease.motion
    goal = goals.driven(active.goal, state.left, elapsed_s, settings)
    asked = goals.wheels(goal, active.power, active.angle_deg, settings, now)
    limited = limit(state, asked, now, state.limited.blocked)
    step = settings.accel_per_s * elapsed_s
    target = _scaled(asked, limited)
    wheels = slew((state.left, state.right), target, step)
    between = FREE if wheels == target else limit(state, wheels, now, limited.blocked)
    left, right = (_within(wheel, settings.max_power) for wheel in _scaled(wheels, between))
    state = replace(state, leases=with_motion(state.leases, replace(active, goal=goal)))
    blocked = active.power > 0.0 and not limited.scale > 0.0
    since = (now if isnan(state.blocked_since) else state.blocked_since) if blocked else nan
    return replace(state, left=left, right=right, limited=limited, blocked_since=since)


def slew(wheels: Wheels, target: Wheels, step: float) -> Wheels:
    """Go towards the target: slower at once, faster by `step` at most and both alike; a new sense begins at zero."""
    goals = [0.0 if wheel * goal < 0.0 else goal for wheel, goal in zip(wheels, target, strict=True)]
    kept = [goal if abs(goal) < abs(wheel) else wheel for wheel, goal in zip(wheels, goals, strict=True)]
    growth = max(abs(goal - wheel) for wheel, goal in zip(kept, goals, strict=True))
    share = step / growth if growth > step else 1.0
    left, right = (wheel + (goal - wheel) * share for wheel, goal in zip(kept, goals, strict=True))
    return left, right


def tell(state: State, now: float) -> tuple[State, Outputs]:
    """Say that a rule began or ceased to limit or stop the base, without a flood when it is on the edge."""
    limited = state.limited
    stops = limited.direction is not None and not limited.scale > 0.0
    key = f"{'stop' if stops else 'slow'} {limited.direction}" if limited.direction else ""
    newly_stopped = stops and not state.told_stop
    if key == state.told or not (state.told == "" or newly_stopped or now - state.told_at >= TELL_AGAIN_S):
        return state, ()
    level: Level = "warning" if stops else "info"
    code = limited.code if limited.direction else ""
    said = Happened(kind="rule", text=_sentence(limited, stops=stops), level=level, code=code)
    return replace(state, told=key, told_stop=stops, told_at=now), (said,)


def _sentence(limited: Limit, *, stops: bool) -> str:
    if limited.direction is None:
        return "no rule limits the base any more"
    if stops:
        return f"the {limited.direction} rule stops the base: {limited.detail}"
    return f"the {limited.direction} rule slows the base to {limited.scale:.0%}: {limited.text}"


def _scaled(wheels: Wheels, limited: Limit) -> Wheels:
    return wheels[0] * limited.scale, wheels[1] * limited.scale


def _within(power: float, highest: float) -> float:
    if not -highest <= power <= highest:
        return highest if power > highest else -highest if power < -highest else 0.0
    return power
