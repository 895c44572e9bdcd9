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
from contextlib import suppress
from typing import Any, NamedTuple

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

    No call takes longer than the deadline. After one that was cut short the stream is out of step and stays closed:
    from then on everything fails with ENODEV until the bus is opened anew.
    """

    def __init__(self, path: str, deadline_s: float = DEADLINE_S) -> None:
        self._deadline_s = deadline_s
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.settimeout(deadline_s)
            self._socket.connect(path)
        except OSError as err:
            self._socket.close()
            # a path that is too long comes without a number
            raise OSError(err.errno or errno.ENAMETOOLONG, err.strerror or str(err)) from err

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
        self._transact([Write(i2c_addr, bytes((register, value)))])

    def write_i2c_block_data(self, i2c_addr: int, register: int, data: Sequence[int]) -> None:
        """Set up to 32 registers."""
        _bounded(len(data))
        self._transact([Write(i2c_addr, bytes((register, *data)))])

    def i2c_rdwr(self, *i2c_msgs: Any) -> None:
        """Do what smbus2's `i2c_msg` objects say, as one transaction, and fill in those that read."""
        messages = [
            Read(each.addr, each.len) if each.flags & READ_FLAG else Write(each.addr, bytes(each)) for each in i2c_msgs
        ]
        data = self._transact(messages)
        for each in i2c_msgs:
            if each.flags & READ_FLAG:
                ctypes.memmove(each.buf, data[: each.len], each.len)
                data = data[each.len :]

    def close(self) -> None:
        """Let go of the socket; never fails."""
        with suppress(OSError):
            self._socket.close()

    def _read(self, address: int, register: int, length: int) -> bytes:
        return self._transact([Write(address, bytes((register,))), Read(address, length)])

    def _transact(self, messages: Sequence[Write | Read]) -> bytes:
        if self._socket.fileno() < 0:
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
        expected = sum(message.length for message in messages if isinstance(message, Read))
        try:
            status, data = self._exchange(encode_transaction(messages), expected)
        except TimeoutError as err:
            self.close()
            raise OSError(errno.ETIMEDOUT, os.strerror(errno.ETIMEDOUT)) from err
        except OSError as err:
            self.close()
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV)) from err
        if status:
            raise OSError(status, os.strerror(status))
        return data

    def _exchange(self, request: bytes, expected: int) -> tuple[int, bytes]:
        until = time.monotonic() + self._deadline_s
        self._socket.settimeout(self._deadline_s)
        self._socket.sendall(request)
        answer = b""
        while True:
            # one byte more than is due, so that a peer out of step shows
            part = self._socket.recv(expected + 2 - len(answer))
            answer += part
            whole = 1 if answer[:1] > b"\0" else expected + 1
            if not part or len(answer) > whole:
                raise ConnectionError("the other end left, or is out of step")
            if len(answer) == whole:
                return answer[0], answer[1:]
            left = until - time.monotonic()
            if not left > 0.0:
                raise TimeoutError
            self._socket.settimeout(left)


def _bounded(length: int) -> None:
    if not 0 < length <= MAX_BLOCK_BYTES:
        raise ValueError(f"a block has 1 to {MAX_BLOCK_BYTES} bytes, not {length}")
