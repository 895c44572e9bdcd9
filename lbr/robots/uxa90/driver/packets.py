"""Packets of SAM servos, as a main board in PC control passes them on: built and checked, never sent. No I/O.

Source: facts of the line by reading (wCK protocol, users' drivers and tools for this robot); see docs/servo_lines.md.
A packet carries its servo's id; an answer is two bytes that carry neither id nor checksum.
"""

from dataclasses import dataclass
from math import isfinite
from typing import NamedTuple

from lbr.robots.uxa90.driver.messages import COUNT_RAD, HIGHEST, LOWEST, MIDDLE

HEAD = 0xFF
HIGHEST_ID = 30
WEAKEST = 4
ANSWER_BYTES = 2
PACKET_BYTES = 4
PASSIVE, READ, CONFIGURE = 6, 5, 7
BREAK_ALL = bytes((HEAD, 0xDF, 0x20, 0x7F))
"""Shorts the motors of all servos: a dynamic brake, without any goal."""


class Answer(NamedTuple):
    """A servo's answer to a move, a read and a passive packet."""

    load: int
    position: int

    @property
    def possible(self) -> bool:
        """Return whether a servo can send this: FF is never a data byte, and zeros are the input of a dead line."""
        return self.load < HEAD and self.position < HEAD and (self.load, self.position) != (0, 0)


def xor(data: bytes | bytearray) -> int:
    """Return the XOR of all bytes."""
    value = 0
    for byte in data:
        value ^= byte
    return value


def move(servo: int, level: int, position: int) -> bytes:
    """Return a position move; torque levels are 0 (strongest, fastest) to 4; raise ValueError for an illegal value."""
    if not 0 <= level <= WEAKEST:
        raise ValueError(f"torque level {level} is outside 0..{WEAKEST}: it would be another command")
    if not LOWEST <= position <= HIGHEST:
        raise ValueError(f"position {position} is outside {LOWEST}..{HIGHEST}")
    return _packet(level << 5 | _checked(servo), position)


def read(servo: int) -> bytes:
    """Return the question for load and position."""
    return _packet(READ << 5 | _checked(servo), 0)


def passive(servo: int) -> bytes:
    """Return the packet that switches a servo's torque off."""
    return _packet(PASSIVE << 5 | _checked(servo), 0x10)


def read14(servo: int) -> bytes:
    """Return the question for the fine position; its answer is two halves of seven bits."""
    return _packet(0xE0, 0xAD, _checked(servo), 0, 0)


def stored(slot: int) -> bytes:
    """Return the packet that plays a motion of the main board without leaving PC control."""
    if not 1 <= slot <= 42:
        raise ValueError(f"slot {slot} is outside 1..42")
    return _packet(0xE0, 0xE1, 0, slot)


@dataclass(frozen=True, slots=True)
class Register:
    """The commands to read and write a servo's value. `twice`: one value, sent twice.

    `read` and `write` are command bytes, None if the command does not exist; `answers`: the bytes in the answer to a
    write.
    """

    name: str
    read: int | None
    write: int | None
    limits: tuple[tuple[int, int], ...] = ()
    twice: bool = False
    answers: int = ANSWER_BYTES


_GAINS = ((1, 254), (0, 254))
_SPEED = ((0, 30), (20, 100))
_INTEGRAL = ((0, 10),)
BAUDS = {921600: 0, 460800: 1, 230400: 3, 115200: 7, 57600: 0x0F, 38400: 0x17, 9600: 0x5F, 4800: 0xBF}
REGISTERS = {
    one.name: one
    for one in (
        Register("position14", 0xAD, None),
        Register("gains", 0x0A, 0x09, _GAINS),
        Register("runtime_gains", None, 0x0B, _GAINS),
        Register("integral_gain", 0x16, 0x15, _INTEGRAL, twice=True),
        Register("runtime_integral_gain", None, 0x18, _INTEGRAL, twice=True),
        Register("speed", 0x0E, 0x0D, _SPEED),
        Register("runtime_speed", None, 0x17, _SPEED, answers=0),
        Register("overload", 0x10, 0x0F, ((33, 199),), twice=True),
        Register("boundary", 0x12, 0x11, ((0, 254), (0, 254))),
        Register("id", None, 0x0C, ((0, HIGHEST_ID),), twice=True),
        Register("baud", None, 0x08, ((0, 0xBF),), twice=True),
        Register("digital_io", 0x65, 0x64, ((0, 3),), twice=True),
    )
}
"""The SAM's configuration, by the names of the messages; ranges from the wCK's manual."""


def ask(register: Register, servo: int) -> bytes:
    """Return the question for a register; raise ValueError if it can only be written."""
    if register.read is None:
        raise ValueError(f"{register.name} can only be written")
    if register.name == "position14":
        return read14(servo)
    return _packet(CONFIGURE << 5 | _checked(servo), register.read, 0, 0)


def configure(register: Register, servo: int, values: tuple[int, ...]) -> bytes:
    """Return the packet that writes a register; raise ValueError with the allowed values."""
    if register.write is None:
        raise ValueError(f"{register.name} can only be read")
    if len(values) != len(register.limits):
        raise ValueError(f"{register.name} takes {len(register.limits)} value(s), not {len(values)}")
    for value, (lowest, highest) in zip(values, register.limits, strict=True):
        if not lowest <= value <= highest:
            raise ValueError(f"{register.name} {value} is outside {lowest}..{highest}")
    if register.name == "baud" and values[0] not in BAUDS.values():
        raise ValueError(f"baud code {values[0]} is not one of {', '.join(map(str, sorted(BAUDS.values())))}")
    if register.name == "boundary" and values[0] >= values[1]:
        raise ValueError(f"boundary {values[0]}..{values[1]} leaves no range")
    both = values * 2 if register.twice else values
    return _packet(CONFIGURE << 5 | _checked(servo), register.write, *both)


def position_rad(count: int) -> float:
    """Return the angle of a count, radians from the middle, count up positive."""
    return (count - MIDDLE) * COUNT_RAD


def position_count(angle_rad: float) -> int:
    """Return the legal count nearest to an angle; raise ValueError for an angle that is not finite."""
    if not isfinite(angle_rad):
        raise ValueError(f"an angle of {angle_rad} rad is not a position")
    return legal(MIDDLE + round(max(-10.0, min(10.0, angle_rad)) / COUNT_RAD))


def legal(count: int) -> int:
    """Return the legal target nearest to a count."""
    return max(LOWEST, min(HIGHEST, count))


def torque_level(fraction: float) -> int:
    """Return the level of a torque above 0; NaN gives the weakest."""
    if not fraction > 0.0:
        return WEAKEST
    return max(0, min(WEAKEST, round((1.0 - min(1.0, fraction)) * 5.0)))


def level_torque(level: int) -> float:
    """Return the fraction of torque for a level."""
    return round(1.0 - level / 5.0, 1)


def _checked(servo: int) -> int:
    if not 0 <= servo <= HIGHEST_ID:
        raise ValueError(f"servo {servo} is outside 0..{HIGHEST_ID}")
    return servo


def _packet(*data: int) -> bytes:
    if HEAD in data:
        raise ValueError("FF is never a data byte")
    body = bytes(data)
    return bytes((HEAD,)) + body + bytes((xor(body) & 0x7F,))
