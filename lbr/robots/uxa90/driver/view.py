"""The public state of the servos and of the main board."""

from lbr.drivers.servos.view import measured_age
from lbr.messages.servos import BusStatistics, ServoState
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.packets import HEAD, level_torque
from lbr.robots.uxa90.driver.plausibility import Seen
from lbr.robots.uxa90.driver.poller import Poller
from lbr.robots.uxa90.driver.targets import ServoTargets, TargetState

MEASURED_S = 0.6


def servo_state(targets: ServoTargets, target: TargetState, seen: Seen, now: float) -> ServoState:
    """Return the state of one servo; untrusted or old values count as not measured."""
    age_s = now - seen.at
    believed = seen.trusted and age_s < MEASURED_S and seen.position is not None and seen.load is not None
    answered = now - seen.raw_at < MEASURED_S
    return ServoState(
        id=target.id,
        position_rad=targets.position_rad(target.id, seen.position) if believed and seen.position is not None else None,
        load=round(seen.load / (HEAD - 1), 4) if believed and seen.load is not None else None,
        goal_rad=targets.goal_rad(target),
        torque=_torque(target),
        raw=(seen.position if believed else seen.raw) if believed or answered else None,
        trusted=True if believed else False if answered else None,
        age_s=measured_age(age_s),
        reason=seen.reason or target.trouble or target.blocked,
    )


def statistics(bus: Bus, poller: Poller) -> BusStatistics:
    """Return the statistics of the line."""
    return BusStatistics(
        sweeps_hz=round(poller.sweeps_hz, 1),
        states_hz=round(poller.states_hz, 1),
        sweep_ms=round(poller.sweep_s * 1000.0, 2),
        timeouts=bus.counts.timeouts,
        corrupt=sum(seen.implausible for seen in poller.seen.values()),
        strays=bus.counts.babble,
    )


def _torque(target: TargetState) -> float | None:
    if not target.known:
        return None
    return level_torque(target.level) if target.on else 0.0
