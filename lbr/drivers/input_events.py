"""The kernel's input events: bytes to types, codes and values. No I/O.

`struct input_event` (linux/input.h) has two times, u16 type, u16 code and i32 value, in the machine's byte order. The
times, seconds and microseconds, are as long as a `long` of this userland. A record has 24 bytes with a long of 64 bits,
else 16.
"""

import struct
from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

EVENT_64, EVENT_32 = struct.Struct("=qqHHi"), struct.Struct("=IIHHi")
EVENT = EVENT_64 if struct.calcsize("l") == 8 else EVENT_32
"""The layout that the kernel uses for this process."""
EV_SYN, EV_KEY, EV_ABS, EV_MSC = 0, 1, 3, 4
SYN_REPORT, SYN_DROPPED = 0, 3
MSC_SCAN = 4
TYPES, CODES = 0x20, 0x300
_LATEST_S = 2**36

R = TypeVar("R")


class InputEvent(NamedTuple):
    """One event; `taken_s` is its time, in seconds of the clock that the device was set to."""

    type: int
    code: int
    value: int
    taken_s: float


class BadRecordError(ValueError):
    """These bytes are not a record."""


class RecordParser(Generic[R]):
    """Turns bytes, in pieces of any size, into the values that `read` returns; other bytes are skipped one by one.

    After a damaged record it is in step again at the next pause at the latest.
    """

    def __init__(self, size: int, read: Callable[[bytes], R | None]) -> None:
        self.passed_over = 0
        self._size = size
        self._read = read
        self._held = b""

    def feed(self, data: bytes) -> list[R]:
        """Return the values that these bytes complete; records for which `read` returns None are left out."""
        held = self._held + data
        values, at = [], 0
        while at + self._size <= len(held):
            try:
                value = self._read(held[at : at + self._size])
            except BadRecordError:
                self.passed_over += 1
                at += 1
                continue
            at += self._size
            if value is not None:
                values.append(value)
        self._held = held[at:]
        return values

    def pause(self) -> None:
        """Drop the held bytes: the kernel writes whole records, so without more input they are the rest of a damaged
        one."""
        self.passed_over += len(self._held)
        self._held = b""


def read_event(record: bytes, layout: struct.Struct = EVENT) -> InputEvent:
    """Return the event in a record; raise BadRecordError if no kernel writes such a record."""
    seconds, micros, type_, code, value = layout.unpack(record)
    if not (0 <= seconds < _LATEST_S and 0 <= micros < 1_000_000 and type_ < TYPES and code < CODES):
        raise BadRecordError
    return InputEvent(type_, code, value, seconds + micros / 1e6)
