"""The motion of a servo without a world: towards its goal at its speed, and more slowly near it."""

from math import copysign, exp, inf

from lbr.simulation.measured import ServoDrive, ServoFelt

_SOFT_S = 0.02


def moved(drive: ServoDrive, felt: ServoFelt, dt_s: float, no_load_rps: float) -> ServoFelt:
    """Return a servo without load `dt_s` later; if it is limp it stays."""
    way = drive.goal_rad - felt.position_rad
    margin, slope = (pair[way > 0] for pair in (drive.margins_rad, drive.slopes_rad))
    if drive.torque <= 0.0 or abs(way) <= margin:
        return ServoFelt(position_rad=felt.position_rad)
    most = min(drive.speed_rps or inf, no_load_rps)
    soft = most * _SOFT_S
    straight_s = max(0.0, (abs(way) - soft) / most)
    remaining = abs(way) - most * min(dt_s, straight_s)
    if dt_s > straight_s:
        remaining *= exp((straight_s - dt_s) / _SOFT_S)
    return ServoFelt(
        position_rad=drive.goal_rad - copysign(remaining, way),
        speed_rps=copysign(min(most, remaining / _SOFT_S), way),
        load=copysign(min(drive.torque, remaining / slope), way),
    )
