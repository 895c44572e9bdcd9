"""The kernel's records of remote control codes: bytes to scancodes. No I/O.

`struct lirc_scancode` (linux/lirc.h): u64 nanoseconds of CLOCK_MONOTONIC, u16 flags, u16 protocol, u32 keycode, u64
scancode. The byte order is the machine's. As an input event a scancode is EV_MSC/MSC_SCAN.
"""

import struct
from dataclasses import dataclass

from lbr.drivers.input_events import CODES, EV_MSC, EVENT, MSC_SCAN, BadRecordError, RecordParser, read_event

ANY_PROTOCOL = 0

_SCANCODE = struct.Struct("=QHHIQ")
_FLAGS = 0x3  # toggle and repeat
_PROTOCOLS = 64
_LATEST_NS = 2**58  # nine years without a restart


@dataclass(frozen=True, slots=True)
class Scancode:
    """A received code; `taken_s` is its time by the device's clock, `protocol` 0 means unknown."""

    code: int
    protocol: int
    taken_s: float


def parser(*, events: bool) -> "RecordParser[Scancode]":
    """Return the parser for the scancodes of an input device, or of a lirc receiver."""
    return RecordParser(EVENT.size, _in_event) if events else RecordParser(_SCANCODE.size, _read)


def _read(record: bytes) -> Scancode:
    """Return what a `struct lirc_scancode` holds."""
    taken_ns, flags, protocol, keycode, code = _SCANCODE.unpack(record)
    if not (
        0 < taken_ns < _LATEST_NS and flags <= _FLAGS and protocol < _PROTOCOLS and keycode < CODES and code < 2**32
    ):
        raise BadRecordError
    return Scancode(code, protocol, taken_ns / 1e9)


def _in_event(record: bytes) -> Scancode | None:
    """Return the scancode of an event; None for a key or the end of a report."""
    event = read_event(record)
    if (event.type, event.code) != (EV_MSC, MSC_SCAN):
        return None
    return Scancode(event.value & 0xFFFFFFFF, ANY_PROTOCOL, event.taken_s)
