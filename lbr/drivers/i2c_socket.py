"""An i2c bus at the other end of a unix socket: each request is one transaction, answered whole or with an errno.

Request: u8 number of messages; for each u8 7-bit address, u8 flags (1: read), u16 length, and the bytes of a write.
Answer: u8 status (0, or an errno), then, if it is 0, the bytes of all reads in order. Numbers are little endian.
"""

import ctypes
import errno
import os
import socket
import struct
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

from lbr.bus.unix_address import address_of

DEADLINE_S = 0.05
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


class SocketBus:
    """The calls of smbus2 over a socket; every failure is an OSError with an errno that a Pi's bus knows too.

    No call takes longer than the deadline. One that was cut short leaves the stream out of step, so that the next one
    connects again.
    """

    def __init__(self, path: str, deadline_s: float = DEADLINE_S) -> None:
        self._path = path
        self._deadline_s = deadline_s
        self._reads: dict[tuple[int, int, int], bytes] = {}
        self._socket: socket.socket | None = self._connect()

    def read_byte_data(self, i2c_addr: int, register: int) -> int:
        """Return one register."""
        return self._read(i2c_addr, register, 1)[0]

    def read_word_data(self, i2c_addr: int, register: int) -> int:
        """Return two registers, the low byte first."""
        return int.from_bytes(self._read(i2c_addr, register, 2), "little")

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Return up to 32 registers of one instant."""
        _bounded(length)
        return list(self._read(i2c_addr, register, length))

    def write_byte_data(self, i2c_addr: int, register: int, value: int) -> None:
        """Set one register."""
        self._transact(encode_transaction([Write(i2c_addr, bytes((register, value)))]))

    def write_i2c_block_data(self, i2c_addr: int, register: int, data: Sequence[int]) -> None:
        """Set up to 32 registers."""
        _bounded(len(data))
        self._transact(encode_transaction([Write(i2c_addr, bytes((register, *data)))]))

    def i2c_rdwr(self, *i2c_msgs: Any) -> None:
        """Do what smbus2's `i2c_msg` objects say, as one transaction, and fill in those that read."""
        messages = [
            Read(each.addr, each.len) if each.flags & READ_FLAG else Write(each.addr, bytes(each)) for each in i2c_msgs
        ]
        expected = sum(message.length for message in messages if isinstance(message, Read))
        data = self._transact(encode_transaction(messages), expected)
        for each in i2c_msgs:
            if each.flags & READ_FLAG:
                ctypes.memmove(each.buf, data[: each.len], each.len)
                data = data[each.len :]

    def close(self) -> None:
        """Close the socket; never fails."""
        connection, self._socket = self._socket, None
        if connection is not None:
            connection.close()

    def _connect(self) -> socket.socket:
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            connection.settimeout(self._deadline_s)
            with address_of(self._path) as address:
                connection.connect(address)
        except OSError:
            connection.close()
            raise
        return connection

    def _read(self, address: int, register: int, length: int) -> bytes:
        wanted = (address, register, length)
        request = self._reads.get(wanted)
        if request is None:
            request = encode_transaction([Write(address, bytes((register,))), Read(address, length)])
            self._reads[wanted] = request
        return self._transact(request, length)

    def _transact(self, request: bytes, expected: int = 0) -> bytes:
        """Return the bytes read, of which `expected` are due."""
        try:
            if self._socket is None:
                self._socket = self._connect()
            answer = self._exchange(self._socket, request, expected)
        except TimeoutError as err:
            self.close()
            raise OSError(errno.ETIMEDOUT, os.strerror(errno.ETIMEDOUT)) from err
        except OSError as err:
            self.close()
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV)) from err
        if answer[0]:
            raise OSError(answer[0], os.strerror(answer[0]))
        return answer[1:]

    def _exchange(self, connection: socket.socket, request: bytes, expected: int) -> bytes:
        until = time.monotonic() + self._deadline_s
        connection.sendall(request)
        answer = connection.recv(expected + 2)  # one more than is due, so that a peer out of step shows
        while len(answer) != (whole := 1 if answer[:1] > b"\0" else expected + 1):
            left = until - time.monotonic()
            if not left > 0.0:
                raise TimeoutError
            connection.settimeout(left)
            part = connection.recv(whole + 1 - len(answer)) if 0 < len(answer) < whole else b""
            if not part:
                raise ConnectionError("the other end left, or is out of step")
            answer += part
            connection.settimeout(self._deadline_s)
        return answer


def _bounded(length: int) -> None:
    if not 0 < length <= MAX_BLOCK_BYTES:
        raise ValueError(f"a block has 1 to {MAX_BLOCK_BYTES} bytes, not {length}")
