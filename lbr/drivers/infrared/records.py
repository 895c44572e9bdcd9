"""The kernel's records of remote control codes: bytes to scancodes. No I/O.

`struct lirc_scancode` (linux/lirc.h): u64 nanoseconds of CLOCK_MONOTONIC, u16 flags, u16 protocol, u32 keycode,
u64 scancode. `struct input_event` (linux/input.h, 64 bit): i64 seconds, i64 microseconds, u16 type, u16 code,
i32 value; a scancode is EV_MSC/MSC_SCAN. Both have 24 bytes, in the byte order of the machine.
"""

import struct
from collections.abc import Callable
from dataclasses import dataclass

RECORD_BYTES = 24
ANY_PROTOCOL = 0

_SCANCODE = struct.Struct("=QHHIQ")
_EVENT = struct.Struct("=qqHHi")
_FLAGS = 0x3  # toggle and repeat
_PROTOCOLS = 64
_KEYS = 0x300
_LATEST_NS = 2**58  # nine years without a restart
_EVENT_TYPES = 0x20
_EV_MSC, _MSC_SCAN = 4, 4


@dataclass(frozen=True, slots=True)
class Scancode:
    """A code as it came in: when, in seconds of the clock of the device; `protocol` 0 is unknown."""

    code: int
    protocol: int
    taken_s: float


class BadRecordError(ValueError):
    """These 24 bytes are no record."""


class RecordParser:
    """Turns bytes, in pieces of any size, into scancodes; what is no record is passed over byte by byte.

    A record is found again after a damaged one at the next pause at the latest.
    """

    def __init__(self, read: Callable[[bytes], Scancode | None]) -> None:
        self.passed_over = 0
        self._read = read
        self._held = b""

    def feed(self, data: bytes) -> list[Scancode]:
        """Return the scancodes that these bytes complete."""
        held = self._held + data
        found, at = [], 0
        while at + RECORD_BYTES <= len(held):
            try:
                scancode = self._read(held[at : at + RECORD_BYTES])
            except BadRecordError:
                self.passed_over += 1
                at += 1
                continue
            at += RECORD_BYTES
            if scancode is not None:
                found.append(scancode)
        self._held = held[at:]
        return found

    def pause(self) -> None:
        """Nothing came: the kernel writes whole records, so what is held is the rest of a damaged one."""
        self.passed_over += len(self._held)
        self._held = b""


def read_scancode(record: bytes) -> Scancode | None:
    """Return what a `struct lirc_scancode` holds."""
    taken_ns, flags, protocol, keycode, code = _SCANCODE.unpack(record)
    if not (
        0 < taken_ns < _LATEST_NS and flags <= _FLAGS and protocol < _PROTOCOLS and keycode < _KEYS and code < 2**32
    ):
        raise BadRecordError
    return Scancode(code, protocol, taken_ns / 1e9)


def read_event(record: bytes) -> Scancode | None:
    """Return what a `struct input_event` holds; None for a key or the end of a report."""
    seconds, micros, type_, code, value = _EVENT.unpack(record)
    if not (0 <= seconds < 2**36 and 0 <= micros < 1_000_000 and type_ < _EVENT_TYPES and code < _KEYS):
        raise BadRecordError
    if (type_, code) != (_EV_MSC, _MSC_SCAN):
        return None
    return Scancode(value & 0xFFFFFFFF, ANY_PROTOCOL, seconds + micros / 1e6)
