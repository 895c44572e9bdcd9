"""Registers of the UPS PIco HV3.0 and the meaning of their bytes; no I/O. Source: its manual, firmware 040.

Status is read at 0x69, commands go to 0x6B. Voltages are words of four binary-coded decimals, the low byte first, in
units of 10 mV; temperatures are one byte of two.
"""

from typing import Literal, NamedTuple

from lbr.errors import MalformedError
from lbr.messages.power import Supply

STATUS_ADDRESS = 0x69
COMMANDS_ABOVE = 2
"""The distance from the status address to the command address, which is 0x6B, or 0x5B."""

MODE, BATTERY, OUTPUT, EXTERNAL, NTC, TO92, CHARGER, COUNTER, FIRMWARE = (
    0x00,
    0x08,
    0x0A,
    0x0C,
    0x1B,
    0x1C,
    0x20,
    0x22,
    0x24,
)
STILL_ALIVE, CHEMISTRY, RELAY = 0x05, 0x07, 0x0C
"""The registers of the command address; the others belong to the status address."""

STILL_ALIVE_OFF = 0xFF
"""The value that switches that timer off. 0 would fire it at once, and is never written."""

_ON_ANOTHER_SOURCE = 0x80
_SOURCES: dict[int, Supply] = {1: "external", 2: "battery"}


class Cell(NamedTuple):
    """A chemistry: its name, the voltage at which the supply switches off, and the further volts of a full battery."""

    name: Literal["lipo", "lifepo4"]
    empty_v: float
    span_v: float


LIPO, LIFEPO4 = Cell("lipo", 3.4, 0.75), Cell("lifepo4", 2.9, 1.25)
_CHEMISTRIES = {ord("S"): LIPO, ord("P"): LIPO, ord("F"): LIFEPO4, ord("Q"): LIFEPO4}


def volts(word: int) -> float:
    """Return the volts of a word of binary-coded decimals; raise MalformedError if it is not one."""
    return decimal(word) / 100


def celsius(byte: int) -> float:
    """Return the degrees of a byte of binary-coded decimals; raise MalformedError if it is not one."""
    return float(decimal(byte))


def decimal(bits: int) -> int:
    """Return the number in binary-coded decimals; raise MalformedError for a digit above nine."""
    digits = f"{bits:x}"
    if not digits.isdecimal():
        raise MalformedError(f"{bits:#x} is no decimal number")
    return int(digits)


def source(mode: int) -> Supply:
    """Return the source of the computer's power, without bit 7; raise MalformedError for an unknown one."""
    found = _SOURCES.get(mode & ~_ON_ANOTHER_SOURCE)
    if found is None:
        raise MalformedError(f"{mode:#04x} is neither external supply (1) nor battery (2)")
    return found


def charging(byte: int) -> bool:
    """Return whether the charger is switched on, even if the battery is full."""
    return flag(byte)


def flag(byte: int) -> bool:
    """Return a byte of 0 or 1 as a bool; raise MalformedError for any other."""
    if byte not in {0, 1}:
        raise MalformedError(f"{byte:#04x} is neither 0 nor 1")
    return byte == 1


def chemistry(byte: int) -> Cell:
    """Return the battery's chemistry; raise MalformedError for an unknown letter."""
    found = _CHEMISTRIES.get(byte)
    if found is None:
        raise MalformedError(f"{byte:#04x} is none of the chemistries S, P, F and Q")
    return found


def charge(battery_v: float, cell: Cell) -> float:
    """Return the charge of the supply's own battery, 0 to 1, as the vendor estimates it."""
    return min(1.0, max(0.0, (battery_v - cell.empty_v) / cell.span_v))


def firmware(board: int, loader: int, version: int) -> str:
    """Return the versions of board, boot loader and firmware in words."""
    letter = chr(loader) if 0x20 < loader < 0x7F else f"{loader:#04x}"
    return f"{version:02x}, board {board:02x}, loader {letter}"
