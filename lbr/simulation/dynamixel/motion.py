"""How a servo turns when no world moves it: towards its goal at its speed, and softly over the last bit."""

from math import copysign, exp, inf, radians

from lbr.simulation.measured import ServoDrive, ServoFelt

STEP_RAD = radians(300.0 / 1023.0)
MIDDLE = 512
SPEED_RPS = radians(0.111 * 6.0)
"""One unit of the registers of speed."""

NO_LOAD_RPS = radians(59.0 * 6.0)

_SOFT_S = 0.02


def moved(drive: ServoDrive, felt: ServoFelt, dt_s: float) -> ServoFelt:
    """Return where a servo that carries nothing is `dt_s` later; limp it stays where it is."""
    way = drive.goal_rad - felt.position_rad
    margin, slope = (pair[way > 0] for pair in (drive.margins_rad, drive.slopes_rad))
    if drive.torque <= 0.0 or abs(way) <= margin:
        return ServoFelt(position_rad=felt.position_rad)
    most = min(drive.speed_rps or inf, NO_LOAD_RPS)
    soft = most * _SOFT_S
    straight_s = max(0.0, (abs(way) - soft) / most)
    left = abs(way) - most * min(dt_s, straight_s)
    if dt_s > straight_s:
        left *= exp((straight_s - dt_s) / _SOFT_S)
    return ServoFelt(
        position_rad=drive.goal_rad - copysign(left, way),
        speed_rps=copysign(min(most, left / _SOFT_S), way),
        load=copysign(min(drive.torque, left / slope), way),
    )


def as_position(position_rad: float) -> int:
    """Return the register of a position; beyond its ends the potentiometer shows the end."""
    return min(1023, max(0, round(position_rad / STEP_RAD) + MIDDLE))


def as_signed(value: float) -> int:
    """Return a register of speed or load: ten bits of magnitude, and one that says clockwise."""
    return min(1023, round(abs(value))) | (1024 if value < 0 else 0)
