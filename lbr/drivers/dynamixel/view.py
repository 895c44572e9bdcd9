"""The state of the bus as others see it: one coherent message out of what was measured and what was told."""

from math import isfinite

from lbr.drivers.dynamixel import table
from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.dynamixel.output import Output
from lbr.drivers.dynamixel.outputs import MEASURED_S
from lbr.drivers.dynamixel.packet import error_names
from lbr.drivers.dynamixel.sweep import Seen, Slow, Snapshot
from lbr.messages.servos import BusStatistics, ServoState

SLOW_BELIEVED_S = 5.0


def servo_state(out: Output, seen: Seen, now: float) -> ServoState:
    """Return one servo; what is older than a moment is not measured."""
    age_s = now - seen.at
    motion = seen.motion if age_s < MEASURED_S else None
    slow = seen.slow if seen.slow is not None and now - seen.slow.at < SLOW_BELIEVED_S else None
    return ServoState(
        id=out.id,
        position_rad=None if motion is None else round(motion.position_rad, 5),
        speed_rps=None if motion is None else round(motion.speed_rps, 4),
        load=None if motion is None else round(motion.load_fraction, 4),
        goal_rad=_goal_rad(out),
        torque=_torque(out, slow),
        voltage_v=None if slow is None else slow.voltage / 10.0,
        temperature_c=None if slow is None else float(slow.temperature),
        faults=error_names(seen.error) if motion is not None else (),
        latched=out.latched,
        raw=None if motion is None else motion.position,
        age_s=round(age_s, 4) if isfinite(age_s) else None,
        reason=seen.reason or out.trouble or out.blocked,
    )


def statistics(bus: Bus, snapshot: Snapshot) -> BusStatistics:
    """Return the figures of the line."""
    counts = bus.counts
    return BusStatistics(
        sweeps_hz=round(snapshot.sweeps_hz, 1),
        states_hz=round(snapshot.states_hz, 1),
        sweep_ms=round(snapshot.sweep_s * 1000.0, 2),
        timeouts=counts.timeouts,
        corrupt=counts.corrupt,
        retries=counts.retries,
        strays=counts.strays,
        sync_read=bus.adapter is not None,
    )


def _goal_rad(out: Output) -> float | None:
    return None if out.goal is None or not out.on else round(table.position_rad(out.goal), 5)


def _torque(out: Output, slow: Slow | None) -> float | None:
    """Return what was told last, or else what was read last."""
    if out.known and (slow is None or out.settled >= slow.at):
        return round(out.limit / table.FULL_TORQUE, 4) if out.on else 0.0
    if slow is None:
        return None
    return round(slow.limit / table.FULL_TORQUE, 4) if slow.enabled else 0.0
