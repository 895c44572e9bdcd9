"""An i2c bus over a stream of bytes: transactions like those of the kernel's I2C_RDWR, and devices by their address.

A request begins with u8 number of messages. Each is u8 address, u8 flags (1: read), u16 LE length and, if it writes,
its bytes. The answer is u8 status, 0 or an errno, and if 0 the bytes of each read message in order.
"""

import errno
import struct
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

MOST_MESSAGES = 42
MOST_BYTES = 8192

_READ = 1
_HEADER = struct.Struct("<BBH")


@dataclass(frozen=True, slots=True)
class Message:
    """One message of a transaction: the bytes that it writes, or the number that it reads."""

    address: int
    write: bytes = b""
    read: int | None = None


class I2cDevice(Protocol):
    """A device on the bus; a message lasts from one start condition to the next."""

    def write(self, data: bytes, now: float) -> bool:
        """Receive bytes; return False for not acknowledged."""

    def read(self, length: int, now: float) -> bytes | None:
        """Return bytes; None for not acknowledged."""


class FramingError(ValueError):
    """The bytes are not a request; the beginning of the next one is unknown."""


class RequestReader:
    """Cuts a client's bytes into transactions, in pieces of any size."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[tuple[Message, ...]]:
        """Return the transactions that are now complete; raise FramingError on other bytes."""
        self._buffer += data
        complete = []
        while (found := self._next()) is not None:
            messages, end = found
            del self._buffer[:end]
            complete.append(messages)
        return complete

    def _next(self) -> tuple[tuple[Message, ...], int] | None:
        buffer = self._buffer
        if not buffer:
            return None
        if not 1 <= buffer[0] <= MOST_MESSAGES:
            raise FramingError(f"an i2c transaction has 1 to {MOST_MESSAGES} messages, not {buffer[0]}")
        messages, at = [], 1
        for _ in range(buffer[0]):
            if len(buffer) < at + _HEADER.size:
                return None
            address, flags, length = _HEADER.unpack_from(buffer, at)
            at += _HEADER.size
            if address > 0x7F or flags & ~_READ or length > MOST_BYTES:
                raise FramingError(f"no i2c message: address {address:#x}, flags {flags:#x}, {length} bytes")
            if flags & _READ:
                messages.append(Message(address, read=length))
                continue
            if len(buffer) < at + length:
                return None
            messages.append(Message(address, write=bytes(buffer[at : at + length])))
            at += length
        return tuple(messages), at


def transfer(devices: Mapping[int, I2cDevice], messages: Sequence[Message], now: float) -> bytes:
    """Carry out a transaction and return the answer: EREMOTEIO as soon as a device does not acknowledge."""
    answer = bytearray(b"\0")
    for message in messages:
        device = devices.get(message.address)
        if device is None:
            return refusal()
        if message.read is None:
            if not device.write(message.write, now):
                return refusal()
            continue
        data = device.read(message.read, now)
        if data is None:
            return refusal()
        answer += data
    return bytes(answer)


def refusal() -> bytes:
    """Return the answer to a transaction that was not acknowledged, as a Raspberry Pi's adapter gives it."""
    return bytes((errno.EREMOTEIO,))


class RegisterDevice(ABC):
    """A device of byte registers behind a pointer, which a write's first byte sets and every byte advances."""

    def __init__(self) -> None:
        self._pointer = 0

    def write(self, data: bytes, now: float) -> bool:
        """Set the pointer, and store the following bytes."""
        self.start(now)
        if data:
            self._pointer = data[0]
        for byte in data[1:]:
            self.store(self._pointer, byte, now)
            self._pointer = self.after(self._pointer)
        return True

    def read(self, length: int, now: float) -> bytes | None:
        """Read from the pointer on; all bytes belong to the instant of the start condition."""
        self.start(now)
        data = bytearray()
        for _ in range(length):
            data.append(self.fetch(self._pointer, now))
            self._pointer = self.after(self._pointer)
        return bytes(data)

    @abstractmethod
    def start(self, now: float) -> None:
        """Update the registers to this instant."""

    @abstractmethod
    def store(self, register: int, value: int, now: float) -> None:
        """Store a byte."""

    @abstractmethod
    def fetch(self, register: int, now: float) -> int:
        """Return a byte."""

    def after(self, register: int) -> int:
        """Return the next position of the pointer."""
        return (register + 1) & 0xFF
