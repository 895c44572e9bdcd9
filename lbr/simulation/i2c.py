"""An i2c bus over a stream of bytes: transactions as the kernel's I2C_RDWR has them, and devices by their address.

A request is u8 number of messages, and for each u8 address, u8 flags (1: read), u16 LE length and, if it writes, its
bytes. The answer is u8 status, 0 or an errno, and if 0 the bytes of each read message in order.
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
    """One message of a transaction: what it writes, or how many bytes it reads."""

    address: int
    write: bytes = b""
    read: int | None = None


class I2cDevice(Protocol):
    """A device on the bus; a message is the time between two start conditions."""

    def write(self, data: bytes, now: float) -> bool:
        """Take bytes; false: not acknowledged."""

    def read(self, length: int, now: float) -> bytes | None:
        """Give bytes; None: not acknowledged."""


class FramingError(ValueError):
    """The bytes are not a request; where the next one begins cannot be known."""


class RequestReader:
    """Cuts what one client sends into transactions, however it is chopped."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[tuple[Message, ...]]:
        """Return the transactions that are now complete; raise FramingError on what can be none."""
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
    """Carry a transaction out and return the answer: EREMOTEIO as soon as a device does not acknowledge."""
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
    """A device of byte registers behind a pointer that a write's first byte sets and every byte moves on."""

    def __init__(self) -> None:
        self._pointer = 0

    def write(self, data: bytes, now: float) -> bool:
        """Set the pointer, and store what follows."""
        self.start(now)
        if data:
            self._pointer = data[0]
        for byte in data[1:]:
            self.store(self._pointer, byte, now)
            self._pointer = self.after(self._pointer)
        return True

    def read(self, length: int, now: float) -> bytes | None:
        """Read from the pointer on; what is read belongs to one instant, that of the start condition."""
        self.start(now)
        data = bytearray()
        for _ in range(length):
            data.append(self.fetch(self._pointer, now))
            self._pointer = self.after(self._pointer)
        return bytes(data)

    @abstractmethod
    def start(self, now: float) -> None:
        """Bring the registers to this instant."""

    @abstractmethod
    def store(self, register: int, value: int, now: float) -> None:
        """Take a byte."""

    @abstractmethod
    def fetch(self, register: int, now: float) -> int:
        """Give a byte."""

    def after(self, register: int) -> int:
        """Return where the pointer moves."""
        return (register + 1) & 0xFF
