"""The state of the servos and of the main board as others see it."""

from math import isfinite

from lbr.drivers.uxa90.bus import Bus
from lbr.drivers.uxa90.output import Out
from lbr.drivers.uxa90.outputs import Outputs
from lbr.drivers.uxa90.packets import HEAD, level_torque
from lbr.drivers.uxa90.sweep import Sweeper
from lbr.drivers.uxa90.trust import Seen
from lbr.messages.servos import BusStatistics, ServoState

MEASURED_S = 0.6


def servo_state(outputs: Outputs, out: Out, seen: Seen, now: float) -> ServoState:
    """Return one servo: what is not believed, or too old, is not measured."""
    age_s = now - seen.at
    believed = seen.trusted and age_s < MEASURED_S and seen.position is not None and seen.load is not None
    heard = now - seen.raw_at < MEASURED_S
    return ServoState(
        id=out.id,
        position_rad=outputs.position_rad(out.id, seen.position) if believed and seen.position is not None else None,
        load=round(seen.load / (HEAD - 1), 4) if believed and seen.load is not None else None,
        goal_rad=outputs.goal_rad(out),
        torque=_torque(out),
        raw=(seen.position if believed else seen.raw) if believed or heard else None,
        trusted=True if believed else False if heard else None,
        age_s=round(age_s, 4) if isfinite(age_s) else None,
        reason=seen.reason or out.trouble or out.blocked,
    )


def statistics(bus: Bus, sweeper: Sweeper) -> BusStatistics:
    """Return the figures of the line."""
    return BusStatistics(
        sweeps_hz=round(sweeper.sweeps_hz, 1),
        states_hz=round(sweeper.states_hz, 1),
        sweep_ms=round(sweeper.sweep_s * 1000.0, 2),
        timeouts=bus.counts.missing,
        corrupt=sum(seen.implausible for seen in sweeper.seen.values()),
        strays=bus.counts.strays,
    )


def _torque(out: Out) -> float | None:
    if not out.known:
        return None
    return level_torque(out.level) if out.on else 0.0
