"""RoboClaw's packet serial: requests out, answers in, after Basicmicro's user manual (rev 5.7). No I/O.

A request is address, command, data, and a CRC-16 of these. The answer to a write is one byte 0xFF; to a read, its data
and a CRC-16 of request and data. Numbers are big-endian.
"""

import struct
from binascii import crc_hqx
from collections.abc import Collection

SET_TIMEOUT, GET_TIMEOUT, VERSION, BATTERY, DUTY, PWM, CURRENTS, ENCODERS, TEMPERATURE, STATUS = (
    *(14, 15, 21, 24),
    *(34, 48, 49, 78, 82, 90),
)
SIZES: dict[int, Collection[int]] = {
    GET_TIMEOUT: (1,),
    VERSION: range(2, 49),
    BATTERY: (2,),
    PWM: (4,),
    CURRENTS: (4,),
    ENCODERS: (8,),
    TEMPERATURE: (2,),
    STATUS: (2, 4),
}
"""The bytes of data in the answer to a read; firmware before 4.1.20 has a status of two bytes."""
ACKNOWLEDGED = b"\xff"
FULL = 32767
TIMEOUT_STEP_MS = 100

FAULTS = (
    *("emergency_stop", "overheat", "overheat_2", "overvoltage", "logic_overvoltage", "logic_undervoltage"),
    *("driver_m1", "driver_m2", "speed_m1", "speed_m2", "position_m1", "position_m2", "current_m1", "current_m2"),
)
"""Bits of a status of four bytes, from the lowest. Higher bits are warnings and limit switches, which stop nothing."""
OLD_FAULTS = dict(enumerate((*("emergency_stop", "overheat", "overheat_2", "overvoltage"), *FAULTS[4:8]), start=2))
"""Bits of a status of two bytes."""


def request(address: int, command: int, data: bytes = b"") -> bytes:
    """Return a request, with its CRC."""
    body = bytes((address, command)) + data
    return body + crc_hqx(body, 0).to_bytes(2, "big")


def duty(address: int, first: float, second: float) -> bytes:
    """Return the request that sets both channels' power, -1..1; other values are limited."""
    values = (round(max(-1.0, min(1.0, power)) * FULL) for power in (first, second))
    return request(address, DUTY, struct.pack(">hh", *values))


def answered(address: int, command: int, heard: bytes) -> bytes | None:
    """Return the data of the answer to a read; None while it is incomplete."""
    asked = crc_hqx(bytes((address, command)), 0)
    for size in SIZES[command]:
        if len(heard) < size + 2:
            break
        if command == VERSION and heard[size - 1] != 0:
            continue
        if crc_hqx(heard[:size], asked) == int.from_bytes(heard[size : size + 2], "big"):
            return heard[:size]
    return None


def longest(command: int) -> int:
    """Return the number of bytes in the longest answer to a read."""
    return max(SIZES[command]) + 2


def faults(status: bytes) -> tuple[str, ...]:
    """Return the names of the faults in a status."""
    mask = int.from_bytes(status, "big")
    bits = dict(enumerate(FAULTS)) if len(status) == 4 else OLD_FAULTS
    return tuple(name for bit, name in bits.items() if mask >> bit & 1)
