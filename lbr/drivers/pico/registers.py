"""Registers of the UPS PIco HV3.0 and what their bytes mean; no I/O. Source: its manual, firmware 040.

Status is read at 0x69, commands go to 0x6B. Voltages are words of four binary-coded decimals, the low byte first, in
units of 10 mV; temperatures are one byte of two.
"""

from typing import Literal, NamedTuple

from lbr.errors import MalformedError
from lbr.messages.power import Supply

STATUS_ADDRESS = 0x69
COMMANDS_ABOVE = 2
"""From the status address to that of commands: 0x6B, or 0x5B where the first was moved to 0x59."""

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
"""These are of the commands; the rest is status."""

STILL_ALIVE_OFF = 0xFF
"""The value that switches that timer off. 0 would fire it at once, and is never written."""

_ON_ANOTHER_SOURCE = 0x80
_SOURCES: dict[int, Supply] = {1: "external", 2: "battery"}


class Cell(NamedTuple):
    """A chemistry: its name, the volts at which the supply gives up, and how many more it has when full."""

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
    """Return the number that binary-coded decimals say; raise MalformedError for a digit above nine."""
    digits = f"{bits:x}"
    if not digits.isdecimal():
        raise MalformedError(f"{bits:#x} is no decimal number")
    return int(digits)


def source(mode: int) -> Supply:
    """Return what feeds the computer; bit 7 says something else. Raise MalformedError for what is neither."""
    found = _SOURCES.get(mode & ~_ON_ANOTHER_SOURCE)
    if found is None:
        raise MalformedError(f"{mode:#04x} is neither external supply (1) nor battery (2)")
    return found


def charging(byte: int) -> bool:
    """Return whether the charger is switched on; a full battery takes nothing all the same."""
    return flag(byte)


def flag(byte: int) -> bool:
    """Return what a byte that is 0 or 1 says; raise MalformedError for any other."""
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
