"""An i2c bus whose transactions are given to a tap, in the words of `i2c_socket`: a recorder hears them so."""

import errno
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from lbr.capability.tap import Tap
from lbr.drivers.i2c_bus import Bus
from lbr.drivers.i2c_socket import READ_FLAG, Read, Write, encode_transaction

T = TypeVar("T")


class TappedBus:
    """Does what the bus does, and tells the tap of it. A transaction that failed has an errno for an answer."""

    def __init__(self, bus: Bus, tap: Tap) -> None:
        self._bus = bus
        self._tap = tap
        tap.opened()

    def read_byte_data(self, i2c_addr: int, register: int) -> int:
        """Return one register."""
        asked: list[Write | Read] = [Write(i2c_addr, bytes((register,))), Read(i2c_addr, 1)]
        return self._told(asked, lambda: self._bus.read_byte_data(i2c_addr, register), lambda got: bytes((got,)))

    def read_word_data(self, i2c_addr: int, register: int) -> int:
        """Return two registers, the low byte first."""
        asked: list[Write | Read] = [Write(i2c_addr, bytes((register,))), Read(i2c_addr, 2)]
        return self._told(
            asked, lambda: self._bus.read_word_data(i2c_addr, register), lambda got: got.to_bytes(2, "little")
        )

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Return up to 32 registers of one instant."""
        asked: list[Write | Read] = [Write(i2c_addr, bytes((register,))), Read(i2c_addr, length)]
        return self._told(asked, lambda: self._bus.read_i2c_block_data(i2c_addr, register, length), bytes)

    def write_byte_data(self, i2c_addr: int, register: int, value: int) -> None:
        """Set one register."""
        asked = [Write(i2c_addr, bytes((register, value)))]
        self._told(asked, lambda: self._bus.write_byte_data(i2c_addr, register, value), _nothing)

    def write_i2c_block_data(self, i2c_addr: int, register: int, data: Sequence[int]) -> None:
        """Set up to 32 registers."""
        asked = [Write(i2c_addr, bytes((register, *data)))]
        self._told(asked, lambda: self._bus.write_i2c_block_data(i2c_addr, register, data), _nothing)

    def i2c_rdwr(self, *i2c_msgs: Any) -> None:
        """Do one transaction of several messages."""
        reads = [each for each in i2c_msgs if each.flags & READ_FLAG]
        asked = [
            Read(each.addr, each.len) if each.flags & READ_FLAG else Write(each.addr, bytes(each)) for each in i2c_msgs
        ]
        self._told(
            asked, lambda: self._bus.i2c_rdwr(*i2c_msgs), lambda _: b"".join(bytes(each)[: each.len] for each in reads)
        )

    def close(self) -> None:
        """Close the device."""
        self._bus.close()

    def _told(self, asked: Sequence[Write | Read], do: Callable[[], T], answer: Callable[[T], bytes]) -> T:
        if not self._tap.wanted:
            return do()
        self._tap.sent(encode_transaction(asked))
        try:
            got = do()
        except OSError as err:
            number = err.errno or errno.EIO
            self._tap.came(bytes((number if 0 < number < 256 else errno.EIO,)))
            raise
        self._tap.came(b"\0" + answer(got))
        return got


def _nothing(_: None) -> bytes:
    return b""
