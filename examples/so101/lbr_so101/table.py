"""The registers of an STS3215 that the driver uses, and the conversion of their numbers to SI units. No I/O.

Source: the vendor's table for firmware 3.6 and later ones. Signs are a bit, never a two's complement.
"""

from math import pi
from typing import NamedTuple

from lbr.drivers.servos.protocol1.register import Register, as_sign_magnitude, sign_magnitude

RAD_PER_STEP = 2.0 * pi / 4096
CENTRE, LAST_STEP, FULL_TORQUE = 2048, 4095, 1000
FASTEST = 4000
"""Steps a second, more than any STS3215 turns; 0 is the greatest speed only if bit 3 of its phase is set."""
SPEED_IN_STEPS, MANY_TURNS = 0x04, 0x10
"""Bits of the phase: speeds are in steps a second, not in fifties; positions count turns."""
_SIGN, _LOAD_SIGN = 15, 10

FIRMWARE = Register("firmware", 0, 2, None, 0xFFFF, "major, minor")
MODEL = Register("model number", 3, 2, None, 0xFFFF, "")
RESPONSE_LEVEL = Register("response level", 8, 1, 0, 1, "")
LOWEST = Register("lowest position", 9, 2, 0, 4094, "steps")
HIGHEST = Register("highest position", 11, 2, 0, 4095, "steps")
MAX_TEMPERATURE = Register("highest temperature", 13, 1, 0, 100, "degrees C")
MAX_VOLTAGE = Register("highest voltage", 14, 1, 0, 254, "0.1 V")
MIN_VOLTAGE = Register("lowest voltage", 15, 1, 0, 254, "0.1 V")
MAX_TORQUE = Register("highest torque", 16, 2, 0, 1000, "0.1 %")
PHASE = Register("phase", 18, 1, 0, 255, "bits")
UNLOADING = Register("unloading conditions", 19, 1, 0, 255, "bits")
MODE = Register("mode", 33, 1, 0, 3, "")
EEPROM_BYTES = 40
TORQUE_ENABLE = Register("torque enable", 40, 1, 0, 1, "")
"""A 2 would brake, and 128 would shift the position: neither is ever written."""
ACCELERATION = Register("acceleration", 41, 1, 0, 254, "100 steps/s2")
GOAL = Register("goal position", 42, 2, 0, 0xFFFF, "steps")
SPEED = Register("goal speed", 46, 2, 0, 0x7FFF, "steps/s")
LIMIT = Register("torque limit", 48, 2, 0, 1000, "0.1 %")

ERRORS = {0: "voltage", 1: "sensor", 2: "overheat", 3: "current", 5: "overload"}
VOLTAGE, OVERHEAT, OVERLOAD = 0x01, 0x04, 0x20


class Motion(NamedTuple):
    """Position, speed and load of a servo, and the error bits that came with them."""

    error: int
    position: int
    speed: int
    load: int

    @property
    def position_rad(self) -> float:
        """Return the position in radians from the middle."""
        return position_rad(self.position)

    @property
    def speed_rps(self) -> float:
        """Return the speed in radians a second."""
        return self.speed * RAD_PER_STEP

    @property
    def load_fraction(self) -> float:
        """Return the load as a fraction of its maximum."""
        return self.load / FULL_TORQUE


def motion(error: int, position: int, speed: int, load: int) -> Motion:
    """Return the motion in registers 56 to 61."""
    where, fast = sign_magnitude(position, _SIGN), sign_magnitude(speed, _SIGN)
    return Motion(error, where, fast, sign_magnitude(load, _LOAD_SIGN))


def goal_bytes(position: int) -> bytes:
    """Return the bytes of a goal."""
    return GOAL.encode(as_sign_magnitude(position, _SIGN))


def goal_of(raw: int) -> int:
    """Return the goal in a register."""
    return sign_magnitude(raw, _SIGN)


def position_rad(raw: int) -> float:
    """Return the angle of a position, radians from the middle."""
    return (raw - CENTRE) * RAD_PER_STEP


def error_names(error: int) -> tuple[str, ...]:
    """Return the names of the error bits that are set."""
    return tuple(ERRORS.get(bit, f"bit {bit}") for bit in range(8) if error >> bit & 1)
