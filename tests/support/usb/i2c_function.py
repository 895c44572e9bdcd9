"""An I2C adaptor on USB, Till Harbaum's i2c-tiny-usb: `/dev/i2c-N`. Behind it is the bus of an emulated device."""

import socket
import struct
from pathlib import Path

from lbr.drivers.i2c_bus import Read, Write, encode_transaction
from tests.support.usb import descriptors as usb
from tests.support.usb.descriptors import Identity
from tests.support.usb.device import Function
from tests.support.usb.usbip import Setup

IDENTITY = Identity(0x0403, 0xC631, "Till Harbaum", "i2c-tiny-usb", "", 0x0205)
ECHO, GET_FUNCTIONS, SET_DELAY, GET_STATUS, TRANSFER = range(5)
BEGIN, END = 1, 2
ACKNOWLEDGED, NOT_ACKNOWLEDGED = 1, 2
FUNCTIONS = 0x0EFF0001
"""I2C, and SMBus emulated by it, block reads of any length among it."""
ANSWER_S = 1.0
"""The kernel waits for 2 s."""


class TinyI2c(Function):
    """Carries a transaction out at the bus of an emulated device.

    `stuck`: the bus hangs, a clock line held low, and no transfer is answered. The kernel asks for message by message and
    the emulated bus takes a transaction whole: where a read follows, what was written before is written once more with it.
    """

    configuration = usb.configuration(usb.interface(0, (255, 0, 0)), interfaces=1)

    def __init__(self, bus: Path, identity: Identity = IDENTITY) -> None:
        self.identity = identity
        self.stuck = False
        self._bus = bus
        self._link: socket.socket | None = None
        self._begun: list[Write | Read] = []
        self._status = ACKNOWLEDGED

    def control(self, setup: Setup, data: bytes) -> bytes | None:
        match setup.request:
            case 0:
                return struct.pack("<H", setup.value)
            case 1:
                return struct.pack("<I", FUNCTIONS)
            case 2:
                return b""
            case 3:
                return bytes((self._status,))
            case request if request & ~(BEGIN | END) == TRANSFER:
                return self._transfer(setup, data)
            case _:
                return None

    def closed(self) -> None:
        if self._link is not None:
            self._link.close()
            self._link = None

    def _transfer(self, setup: Setup, data: bytes) -> bytes | None:
        if self.stuck:
            return None
        if setup.request & BEGIN:
            self._begun = []
        reads = bool(setup.value & 1)
        message = Read(setup.index, setup.length) if reads else Write(setup.index, data)
        self._begun.append(message)
        found = self._asked(self._begun)
        self._status = NOT_ACKNOWLEDGED if found is None else ACKNOWLEDGED
        if setup.request & END:
            self._begun = []
        if not reads:
            return b""
        return bytes(setup.length) if found is None else found[-setup.length :]

    def _asked(self, messages: list[Write | Read]) -> bytes | None:
        """Return all that the transaction reads; None if a device did not acknowledge, or there is none."""
        want = sum(one.length for one in messages if isinstance(one, Read))
        try:
            link = self._connected()
            link.sendall(encode_transaction(messages))
            if link.recv(1) == b"\0":
                return _received(link, want)
        except OSError:
            self.closed()  # an answer that comes later would be taken for another's
        return None

    def _connected(self) -> socket.socket:
        if self._link is None:
            self._link = socket.socket(socket.AF_UNIX)
            self._link.settimeout(ANSWER_S)
            self._link.connect(str(self._bus))
        return self._link


def _received(link: socket.socket, count: int) -> bytes:
    found = b""
    while len(found) < count:
        piece = link.recv(count - len(found))
        if not piece:
            raise ConnectionError("the bus is gone")
        found += piece
    return found
