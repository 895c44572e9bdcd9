"""The AX-12A's control table, and its numbers in SI units. No I/O.

Source: ROBOTIS e-manual of the AX-12A; ranges of written values: AX-12 manual of 2006.
"""

from math import isfinite, radians
from typing import NamedTuple

from lbr.drivers.servos.protocol1.register import Register, sign_magnitude

MODEL = 12
POSITION_STEPS = 1023
CENTRE = 512
RAD_PER_STEP = radians(300.0) / POSITION_STEPS
RPS_PER_STEP = 0.011624
"""0.111 rpm."""
MAX_SPEED = 1023
FULL_TORQUE = 1023
SIGN_BIT = 10
"""The sign bit of speed and load: clockwise."""


RAM = 24
"""The first address of RAM. Below it is EEPROM, which is written only without torque and with a pause."""
MODEL_NUMBER = Register("model number", 0, 2, None, 0xFFFF, "")
FIRMWARE = Register("firmware version", 2, 1, None, 0xFF, "")
ID = Register("id", 3, 1, 0, 252, "")
RETURN_DELAY = Register("return delay time", 5, 1, 0, 254, "2 us")
CW_LIMIT = Register("CW angle limit", 6, 2, 0, 1023, "300/1023 deg")
CCW_LIMIT = Register("CCW angle limit", 8, 2, 0, 1023, "300/1023 deg")
TEMPERATURE_LIMIT = Register("temperature limit", 11, 1, 0, 150, "deg C")
MIN_VOLTAGE = Register("lowest voltage", 12, 1, 50, 160, "0.1 V")
MAX_VOLTAGE = Register("highest voltage", 13, 1, 50, 160, "0.1 V")
MAX_TORQUE = Register("max torque", 14, 2, 0, 1023, "1/1023")
RETURN_LEVEL = Register("status return level", 16, 1, 0, 2, "")
ALARM_LED = Register("alarm LED", 17, 1, 0, 127, "error bits")
SHUTDOWN = Register("shutdown", 18, 1, 0, 127, "error bits")
TORQUE_ENABLE = Register("torque enable", 24, 1, 0, 1, "")
LED = Register("LED", 25, 1, 0, 1, "")
CW_MARGIN = Register("CW compliance margin", 26, 1, 0, 254, "300/1023 deg")
CCW_MARGIN = Register("CCW compliance margin", 27, 1, 0, 254, "300/1023 deg")
CW_SLOPE = Register("CW compliance slope", 28, 1, 1, 254, "300/1023 deg")
CCW_SLOPE = Register("CCW compliance slope", 29, 1, 1, 254, "300/1023 deg")
GOAL_POSITION = Register("goal position", 30, 2, 0, 1023, "300/1023 deg")
MOVING_SPEED = Register("moving speed", 32, 2, 0, 2047, "0.111 rpm")
TORQUE_LIMIT = Register("torque limit", 34, 2, 0, 1023, "1/1023")
PRESENT_POSITION = Register("present position", 36, 2, None, 1023, "300/1023 deg")
PRESENT_SPEED = Register("present speed", 38, 2, None, 2047, "0.111 rpm, bit 10: CW")
PRESENT_LOAD = Register("present load", 40, 2, None, 2047, "1/1023, bit 10: CW")
PRESENT_VOLTAGE = Register("present voltage", 42, 1, None, 255, "0.1 V")
PRESENT_TEMPERATURE = Register("present temperature", 43, 1, None, 255, "deg C")
REGISTERED = Register("registered", 44, 1, None, 1, "")
MOVING = Register("moving", 46, 1, None, 1, "")
LOCK = Register("lock", 47, 1, 1, 1, "")
PUNCH = Register("punch", 48, 2, 0, 1023, "1/1023")

REGISTERS = tuple(value for value in tuple(globals().values()) if isinstance(value, Register))
"""All of them, by address."""


class Motion(NamedTuple):
    """Position, speed and load as one READ of 36..41 returns them, raw, with the error bits of its answer."""

    error: int
    position: int
    speed: int
    load: int

    @property
    def position_rad(self) -> float:
        """Radians from the middle, CCW positive."""
        return position_rad(self.position)

    @property
    def speed_rps(self) -> float:
        """Radians a second, CCW positive."""
        return signed(self.speed) * RPS_PER_STEP

    @property
    def load_fraction(self) -> float:
        """Fraction of the maximum, CCW positive; the servo infers it."""
        return signed(self.load) / FULL_TORQUE


MOTION_BYTES = 6
MOTION_ADDRESS = PRESENT_POSITION.address
SAG = 10
"""The distance below its goal at which a servo may rest under load, in counts (2.9 degrees). Chosen, not measured on a
real robot. With the factory's compliance slope of 32 counts a servo yields by up to 9.4 degrees at full effort."""


def holding_goal(position: int, speed: int, goal: int) -> int:
    """Return the raw goal that holds a servo where it is: near its goal that goal itself, or the servo would sag
    further."""
    return goal if signed(speed) == 0 and abs(goal - position) <= SAG else position


def position_rad(raw: int) -> float:
    """Return the angle of a position, radians from the middle, CCW positive."""
    return (raw - CENTRE) * RAD_PER_STEP


def position_raw(angle_rad: float) -> int:
    """Return the position nearest to an angle, within the servo's range; raise ValueError if it is not finite."""
    if not isfinite(angle_rad):
        raise ValueError(f"an angle of {angle_rad} rad is not a position")
    return max(0, min(POSITION_STEPS, CENTRE + round(_bounded(angle_rad) / RAD_PER_STEP)))


def speed_raw(speed_rps: float | None) -> int:
    """Return the raw moving speed; None is full speed, which the servo encodes as 0, so a slow speed is at least 1."""
    if speed_rps is None:
        return 0
    if not isfinite(speed_rps) or speed_rps <= 0.0:
        raise ValueError(f"a speed of {speed_rps} rad/s moves nothing")
    return max(1, min(MAX_SPEED, round(_bounded(speed_rps) / RPS_PER_STEP)))


def torque_raw(fraction: float) -> int:
    """Return the raw torque limit for a fraction: at least 1 if it is positive, 0 if it is not a number."""
    if not 0.0 < fraction <= 1.0:
        return FULL_TORQUE if fraction > 1.0 else 0
    return max(1, round(fraction * FULL_TORQUE))


def _bounded(value: float) -> float:
    """Limit a value to a range beyond anything that a servo does, so that rounding cannot overflow."""
    return max(-100.0, min(100.0, value))


def signed(raw: int) -> int:
    """Return speed or load with its sign: bit 10 means clockwise, which is negative."""
    return sign_magnitude(raw, SIGN_BIT)
