"""The turn of a servo when no world moves it: towards its goal at its speed, and softly over the last bit."""

from math import copysign, exp, inf

from lbr.simulation.measured import ServoDrive, ServoFelt

_SOFT_S = 0.02


def moved(drive: ServoDrive, felt: ServoFelt, dt_s: float, no_load_rps: float) -> ServoFelt:
    """Return where a servo that carries nothing is `dt_s` later; limp it stays where it is."""
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
