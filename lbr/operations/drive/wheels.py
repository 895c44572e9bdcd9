"""From the lease to the next setpoint: mixing, then rules, then slew, then the limit."""

from math import isnan, nan

from msgspec.structs import replace

from lbr.leases.decide import with_motion
from lbr.leases.lease import Happened, Level
from lbr.messages.motors import MotorSetpoint
from lbr.operations.drive import goals, obstacle_memory
from lbr.operations.drive.command import Sides, times
from lbr.operations.drive.limits import limit
from lbr.operations.drive.rules import FREE, Limit
from lbr.operations.drive.state import Outputs, State

LONGEST_STEP_S = 0.1
"""The longest step that counts: older setpoints move nothing."""
REPORT_AGAIN_S = 1.0


def next_wheels(state: State, now: float) -> State:
    """Return the state with the wheels' next powers, and the base's own estimate of its way meanwhile."""
    elapsed_s = min(max(0.0, now - state.ticked), LONGEST_STEP_S)  # this way round, NaN is no time
    settings = state.settings
    odometer = state.odometer.driven(state.left, state.right, elapsed_s, settings.max_speed_mps, state.aside)
    remembered = obstacle_memory.moved(state.memory, state.left, state.right, elapsed_s, settings, state.aside)
    state = replace(state, odometer=odometer, memory=remembered, ticked=now)
    lease = state.lease
    if lease is None:
        return replace(state, left=0.0, right=0.0, aside=0.0, limited=FREE, reported_rule="")
    active = lease.motion
    goal = goals.driven(active.goal, state, elapsed_s, now)
    asked = active.sides
    if asked is None:
        asked = (*goals.wheels(goal, active.power, active.angle_deg, settings, now), 0.0)
    limited = limit(state, asked, now, state.limited.blocked)
    stands = not any(state.sides)
    step = settings.accel_per_s * (min(elapsed_s, 1.0 / settings.rate_hz) if stands else elapsed_s)
    target = times(asked, limited.scale)
    sides = slew(state.sides, target, step)
    between = FREE if sides == target else limit(state, sides, now, limited.blocked)
    sides = times(sides, between.scale)
    left, right, aside = times(sides, state.base.fitting(*sides, settings.max_power))
    state = replace(state, leases=with_motion(state.leases, replace(active, goal=goal)))
    since = nan if limited.scale > 0.0 else now if isnan(state.blocked_since) else state.blocked_since
    begun = now if stands else state.begun
    return replace(state, left=left, right=right, aside=aside, limited=limited, blocked_since=since, begun=begun)


def setpoint_of(state: State, lease: str) -> MotorSetpoint:
    """Return the setpoint of the motors, by name if they are others than `left` and `right`."""
    base = state.base
    motors = {} if base.two else dict(zip(base.motors, base.powers(*state.sides), strict=True))
    moving_s = state.ticked - state.begun if any(state.sides) else 0.0
    return MotorSetpoint(left=state.left, right=state.right, lease=lease, motors=motors, moving_s=moving_s)


def slew(sides: Sides, target: Sides, step: float) -> Sides:
    """Go towards the target: slower at once, faster by `step` at most and all alike; a reversal passes through zero."""
    goals = [0.0 if side * goal < 0.0 else goal for side, goal in zip(sides, target, strict=True)]
    slowed = [goal if abs(goal) < abs(side) else side for side, goal in zip(sides, goals, strict=True)]
    growth = max(abs(goal - side) for side, goal in zip(slowed, goals, strict=True))
    share = step / growth if growth > step else 1.0
    left, right, aside = (side + (goal - side) * share for side, goal in zip(slowed, goals, strict=True))
    return left, right, aside


def tell(state: State, now: float) -> tuple[State, Outputs]:
    """Report that a rule began or ceased to limit or stop the base, with a limit on the rate of reports."""
    limited = state.limited
    stops = limited.direction is not None and not limited.scale > 0.0
    key = f"{'stop' if stops else 'slow'} {limited.direction}" if limited.direction else ""
    newly_stopped = stops and not state.reported_rule.startswith("stop")
    if key == state.reported_rule or not (
        state.reported_rule == "" or newly_stopped or now - state.reported_at >= REPORT_AGAIN_S
    ):
        return state, ()
    level: Level = "warning" if stops else "info"
    code = limited.code if limited.direction else ""
    change = Happened(kind="rule", text=_sentence(limited, stops=stops), level=level, code=code)
    return replace(state, reported_rule=key, reported_at=now), (change,)


def _sentence(limited: Limit, *, stops: bool) -> str:
    if limited.direction is None:
        return "no rule limits the base any more"
    if stops:
        return f"the {limited.direction} rule stops the base: {limited.detail}"
    return f"the {limited.direction} rule slows the base to {limited.scale:.0%}: {limited.text}"
