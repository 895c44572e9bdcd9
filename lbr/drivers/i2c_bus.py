"""The interface of an i2c bus for drivers, on real hardware or a socket; a recorder receives its transactions.

A transaction for the recorder, as on a socket, starts with u8 number of messages. Each message has u8 7-bit address, u8
flags (1: read), u16 length, and the bytes of a write. Its answer: u8 status (0, or an errno), then, if it is 0, the
bytes of all reads in order. Numbers are little endian.
"""

import errno
import struct
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

from lbr.capability.tap import Tap

MAX_BLOCK_BYTES = 32
READ_FLAG = 1
_HEAD = struct.Struct("<BBH")


class Write(NamedTuple):
    """One message of a transaction: bytes to a device."""

    address: int
    data: bytes


class Read(NamedTuple):
    """One message of a transaction: `length` bytes from a device."""

    address: int
    length: int


def encode_transaction(messages: Sequence[Write | Read]) -> bytes:
    """Return the request for a transaction of 1 to 255 messages."""
    parts = [bytes((len(messages),))]
    for message in messages:
        if isinstance(message, Write):
            parts += [_HEAD.pack(message.address, 0, len(message.data)), message.data]
        else:
            parts.append(_HEAD.pack(message.address, READ_FLAG, message.length))
    return b"".join(parts)


class Bus(ABC):
    """The calls of `smbus2.SMBus` that drivers use; each is one transaction and raises OSError with an errno if it
    fails."""

    def __init__(self, tap: Tap) -> None:
        self._tap = tap
        tap.opened()

    def read_byte_data(self, address: int, register: int) -> int:
        """Return one register."""
        return self._recorded(address, bytes((register,)), 1)[0]

    def read_word_data(self, address: int, register: int) -> int:
        """Return two registers, the low byte first."""
        return int.from_bytes(self._recorded(address, bytes((register,)), 2), "little")

    def read_i2c_block_data(self, address: int, register: int, length: int) -> list[int]:
        """Return up to 32 registers, read at one instant."""
        _check_length(length)
        return list(self._recorded(address, bytes((register,)), length))

    def write_byte_data(self, address: int, register: int, value: int) -> None:
        """Set one register."""
        self._recorded(address, bytes((register, value)))

    def write_i2c_block_data(self, address: int, register: int, data: Sequence[int]) -> None:
        """Set up to 32 registers."""
        _check_length(len(data))
        self._recorded(address, bytes((register, *data)))

    @abstractmethod
    def transact(self, address: int, written: bytes, length: int) -> bytes:
        """Write a register's number and its new content, or read `length` bytes from that register on."""

    @abstractmethod
    def close(self) -> None:
        """Close the device."""

    def _recorded(self, address: int, written: bytes, length: int = 0) -> bytes:
        """Do a transaction; the recorder gets the errno of a failed one as its answer."""
        self._tap.sent(encode(address, written, length))
        try:
            data = self.transact(address, written, length)
        except OSError as err:
            number = err.errno or errno.EIO
            self._tap.came(bytes((number if 0 < number < 256 else errno.EIO,)))
            raise
        self._tap.came(b"\0" + data)
        return data


def encode(address: int, written: bytes, length: int) -> bytes:
    """Return the request for what `transact` does."""
    return encode_transaction([Write(address, written), *([Read(address, length)] if length else [])])


def _check_length(length: int) -> None:
    if not 0 < length <= MAX_BLOCK_BYTES:
        raise ValueError(f"a block has 1 to {MAX_BLOCK_BYTES} bytes, not {length}")
