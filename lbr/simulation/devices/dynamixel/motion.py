"""The counts of positions and speeds in a servo's registers."""

from math import radians

STEP_RAD = radians(300.0 / 1023.0)
MIDDLE = 512
SPEED_RPS = radians(0.111 * 6.0)
"""One unit of the registers of speed."""

NO_LOAD_RPS = radians(59.0 * 6.0)


def as_position(position_rad: float) -> int:
    """Return the register of a position; beyond its ends the potentiometer shows the end."""
    return min(1023, max(0, round(position_rad / STEP_RAD) + MIDDLE))


def as_signed(value: float) -> int:
    """Return a register of speed or load: ten bits of magnitude, and one for clockwise."""
    return min(1023, round(abs(value))) | (1024 if value < 0 else 0)
