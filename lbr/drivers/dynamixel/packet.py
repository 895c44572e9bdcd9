"""Dynamixel's own part of protocol 1.0: the names of error bits, and a USB2AX's packet that reads several servos.

Source: ROBOTIS e-manual, protocol 1.0; USB2AX firmware v04 and v05.
"""

from collections.abc import Iterable

from lbr.drivers.servos.protocol1 import packet

ADAPTER = packet.HIGHEST_ANSWERING
"""The id of a USB2AX itself."""
ADAPTER_SYNC_READ = 0x84
ERRORS = ("voltage", "angle_limit", "overheat", "range", "checksum", "overload", "instruction")
"""Names of the bits in a status packet's error byte, from the lowest."""


def adapter_sync_read(address: int, count: int, servos: Iterable[int]) -> bytes:
    """Return the USB2AX's own READ of the same bytes of several servos; it fills in FF for silent ones."""
    return packet.instruction(ADAPTER, ADAPTER_SYNC_READ, bytes((address, count, *servos)))


def error_names(error: int) -> tuple[str, ...]:
    """Return the names of the error bits that are set."""
    return tuple(name for bit, name in enumerate(ERRORS) if error >> bit & 1)


def error_mask(*names: str) -> int:
    """Return the error byte with these bits set; also the form of the registers alarm LED and shutdown."""
    return sum(1 << ERRORS.index(name) for name in names)
