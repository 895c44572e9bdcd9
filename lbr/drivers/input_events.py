"""The kernel's input events: bytes to types, codes and values. No I/O.

`struct input_event` (linux/input.h): seconds and microseconds as long as a `long` of this userland, u16 type, u16 code,
i32 value, in the byte order of the machine: 24 bytes where a long has 64 bits, else 16.
"""

import struct
from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

EVENT_64, EVENT_32 = struct.Struct("=qqHHi"), struct.Struct("=IIHHi")
EVENT = EVENT_64 if struct.calcsize("l") == 8 else EVENT_32
"""As the kernel writes it to this process."""
EV_SYN, EV_KEY, EV_ABS, EV_MSC = 0, 1, 3, 4
SYN_REPORT, SYN_DROPPED = 0, 3
MSC_SCAN = 4
TYPES, CODES = 0x20, 0x300
_LATEST_S = 2**36

R = TypeVar("R")


class InputEvent(NamedTuple):
    """One event; `taken_s` is when, in seconds of the clock that the device was told to go by."""

    type: int
    code: int
    value: int
    taken_s: float


class BadRecordError(ValueError):
    """These bytes are no record."""


class RecordParser(Generic[R]):
    """Turns bytes, in pieces of any size, into `read`'s values of records; other bytes are passed over one by one.

    A record is found again after a damaged one at the next pause at the latest.
    """

    def __init__(self, size: int, read: Callable[[bytes], R | None]) -> None:
        self.passed_over = 0
        self._size = size
        self._read = read
        self._held = b""

    def feed(self, data: bytes) -> list[R]:
        """Return what these bytes complete; a record of which nothing is made is left out."""
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
        """Nothing came: the kernel writes whole records, so what is held is the rest of a damaged one."""
        self.passed_over += len(self._held)
        self._held = b""


def read_event(record: bytes, layout: struct.Struct = EVENT) -> InputEvent:
    """Return what a record holds; raise BadRecordError if no kernel writes such a one."""
    seconds, micros, type_, code, value = layout.unpack(record)
    if not (0 <= seconds < _LATEST_S and 0 <= micros < 1_000_000 and type_ < TYPES and code < CODES):
        raise BadRecordError
    return InputEvent(type_, code, value, seconds + micros / 1e6)
