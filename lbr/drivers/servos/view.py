"""The published state of the bus: one coherent message from readings and orders."""

from math import isfinite

from lbr.drivers.servos.contract import Seen, ServoBus, ServoModel, SlowState, Snapshot
from lbr.drivers.servos.targets import MEASURED_S, TargetState
from lbr.messages.servos import BusStatistics, ServoState

SLOW_BELIEVED_S = 5.0


def servo_state(target: TargetState, seen: Seen, model: ServoModel, now: float) -> ServoState:
    """Return the state of one servo; older values count as not measured."""
    age_s = now - seen.at
    motion = seen.motion if age_s < MEASURED_S else None
    slow = seen.slow if seen.slow is not None and now - seen.slow.at < SLOW_BELIEVED_S else None
    return ServoState(
        id=target.id,
        position_rad=None if motion is None else round(motion.position_rad, 5),
        speed_rps=None if motion is None else round(motion.speed_rps, 4),
        load=None if motion is None else round(motion.load_fraction, 4),
        goal_rad=None if target.goal is None or not target.on else round(model.position_rad(target.goal), 5),
        torque=_torque(target, slow, model.full_torque),
        voltage_v=None if slow is None else slow.voltage_v,
        temperature_c=None if slow is None else slow.temperature_c,
        faults=model.faults(seen.error) if motion is not None else (),
        latched=target.latched,
        raw=None if motion is None else motion.position,
        age_s=measured_age(age_s),
        reason=seen.reason or target.trouble or target.blocked,
    )


def statistics(bus: ServoBus, snapshot: Snapshot) -> BusStatistics:
    """Return the statistics of the line."""
    counts = bus.counts
    return BusStatistics(
        sweeps_hz=round(snapshot.sweeps_hz, 1),
        states_hz=round(snapshot.states_hz, 1),
        sweep_ms=round(snapshot.sweep_s * 1000.0, 2),
        timeouts=counts.timeouts,
        corrupt=counts.corrupt,
        retries=counts.retries,
        strays=counts.strays,
        sync_read=snapshot.together,
    )


def measured_age(age_s: float) -> float | None:
    """Return an age as messages have it: None before the first measurement."""
    return round(age_s, 4) if isfinite(age_s) else None


def _torque(target: TargetState, slow: SlowState | None, full: int) -> float | None:
    """Return the torque of the last order, or of a newer reading."""
    if target.known and (slow is None or target.settled >= slow.at):
        return round(target.limit / full, 4) if target.on else 0.0
    if slow is None:
        return None
    return round(slow.limit / full, 4) if slow.enabled else 0.0
