"""The control table of an AX-12A (e-manual; ranges of writing from the AX-12 manual of 2006)."""

from bisect import bisect_right
from typing import NamedTuple

MODEL = 12
FIRMWARE = 24
SIZE = 50
RAM = 24
"""Registers below it are EEPROM, kept without power."""

ID, BAUD, RETURN_DELAY, CW_LIMIT, CCW_LIMIT = 3, 4, 5, 6, 8
HEAT_LIMIT_C, LEAST_VOLTAGE, MOST_VOLTAGE, MOST_TORQUE, RETURN_LEVEL, SHUTDOWN = 11, 12, 13, 14, 16, 18
TORQUE, CW_MARGIN, CCW_MARGIN, CW_SLOPE, CCW_SLOPE, GOAL, SPEED, TORQUE_LIMIT = 24, 26, 27, 28, 29, 30, 32, 34
PRESENT, VOLTAGE, REGISTERED, MOVING, LOCK, PUNCH = 36, 42, 44, 46, 47, 48


class Register(NamedTuple):
    """A writable register, with its range."""

    address: int
    size: int
    least: int
    most: int
    default: int


_REGISTERS = (
    Register(ID, 1, 0, 253, 1),
    Register(BAUD, 1, 0, 254, 1),
    Register(RETURN_DELAY, 1, 0, 254, 250),
    Register(CW_LIMIT, 2, 0, 1023, 0),
    Register(CCW_LIMIT, 2, 0, 1023, 1023),
    Register(HEAT_LIMIT_C, 1, 0, 150, 70),
    Register(LEAST_VOLTAGE, 1, 50, 250, 60),
    Register(MOST_VOLTAGE, 1, 50, 250, 140),
    Register(MOST_TORQUE, 2, 0, 1023, 1023),
    Register(RETURN_LEVEL, 1, 0, 2, 2),
    Register(17, 1, 0, 127, 36),
    Register(SHUTDOWN, 1, 0, 127, 36),
    Register(TORQUE, 1, 0, 1, 0),
    Register(25, 1, 0, 1, 0),
    Register(CW_MARGIN, 1, 0, 254, 1),
    Register(CCW_MARGIN, 1, 0, 254, 1),
    Register(CW_SLOPE, 1, 1, 254, 32),
    Register(CCW_SLOPE, 1, 1, 254, 32),
    Register(GOAL, 2, 0, 1023, 512),
    Register(SPEED, 2, 0, 2047, 0),
    Register(TORQUE_LIMIT, 2, 0, 1023, 1023),
    Register(LOCK, 1, 1, 1, 0),
    Register(PUNCH, 2, 0, 1023, 32),
)
_STARTS = [register.address for register in _REGISTERS]


def word(table: bytes | bytearray, address: int) -> int:
    """Return the two bytes at an address as a number."""
    return table[address] | table[address + 1] << 8


def put_word(table: bytearray, address: int, value: int) -> None:
    """Put a number into the two bytes at an address."""
    table[address] = value & 0xFF
    table[address + 1] = value >> 8


def factory() -> bytearray:
    """Return the table with the factory's values."""
    table = bytearray(SIZE)
    put_word(table, 0, MODEL)
    table[2] = FIRMWARE
    for register in _REGISTERS:
        _put(table, register)
    return table


def boot(table: bytearray) -> None:
    """Reset the RAM to its values at power-up."""
    table[RAM:] = bytes(SIZE - RAM)
    for register in _REGISTERS:
        if register.address >= RAM:
            _put(table, register)
    table[TORQUE_LIMIT : TORQUE_LIMIT + 2] = table[MOST_TORQUE : MOST_TORQUE + 2]


def touched(address: int, count: int) -> list[Register] | None:
    """Return the registers of a write; None if one of them is read-only."""
    registers, at, end = [], address, address + count
    while at < end:
        index = bisect_right(_STARTS, at) - 1
        register = _REGISTERS[index] if index >= 0 else None
        if register is None or at >= register.address + register.size:
            return None
        registers.append(register)
        at = register.address + register.size
    return registers


def in_range(table: bytearray, register: Register) -> bool:
    """Return whether a register's value is in its range."""
    value = word(table, register.address) if register.size == 2 else table[register.address]
    return register.least <= value <= register.most


def _put(table: bytearray, register: Register) -> None:
    if register.size == 2:
        put_word(table, register.address, register.default)
    else:
        table[register.address] = register.default
