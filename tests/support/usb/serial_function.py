"""USB serial devices: CDC-ACM as Arduinos, Roboteqs and servo boards have it, and FTDI's FT232R. Behind each is a tty."""

import errno
import os
import struct
import termios
import time
import tty
from abc import abstractmethod
from contextlib import suppress
from pathlib import Path

from tests.support.usb import descriptors as usb
from tests.support.usb.descriptors import Identity
from tests.support.usb.device import Function
from tests.support.usb.usbip import Setup

READ_BYTES = 4096
RATES = {int(name[1:]): getattr(termios, name) for name in dir(termios) if name[0] == "B" and name[1:].isdigit()}
TOLERATED = 0.02
"""So far off a UART may be: divisors do not meet every rate."""


class SerialFunction(Function):
    """Bytes between the host and the tty of an emulated device, which stays what it is when the cable is pulled.

    `piece`: no transfer to the host has more bytes than this, and each comes `pause_s` after the one before. `baud` is
    what the host set last, `resets` counts how often the line was opened.
    """

    packet = 64

    def __init__(self, line: Path, identity: Identity) -> None:
        self.identity = identity
        self.piece, self.pause_s = 0, 0.0
        self.baud = 0
        self._again_at = 0.0
        self._tty = os.open(line, os.O_RDWR | os.O_NONBLOCK | os.O_NOCTTY)
        tty.setraw(self._tty)

    def watched(self) -> int | None:
        return self._tty if time.monotonic() >= self._again_at else None

    def due(self) -> float | None:
        return self._again_at if time.monotonic() < self._again_at else None

    def come(self, room: int) -> bytes:
        wanted = min(room, READ_BYTES, self.piece or READ_BYTES)
        try:
            data = os.read(self._tty, wanted)
        except BlockingIOError:
            return b""
        except OSError as err:
            if err.errno != errno.EIO:
                raise
            return b""  # the device has no power
        self._again_at = time.monotonic() + self.pause_s
        return data

    def out(self, endpoint: int, data: bytes) -> None:
        with suppress(BlockingIOError):  # a device that does not read loses what comes
            os.write(self._tty, data)

    def finish(self) -> None:
        """Close the tty."""
        os.close(self._tty)

    def _set_baud(self, baud: int) -> None:
        self.baud = min(RATES, key=lambda one: abs(one - baud))
        if abs(self.baud - baud) <= baud * TOLERATED:  # the emulated device refuses what comes at another rate
            constant = RATES[self.baud]
            attributes = termios.tcgetattr(self._tty)
            attributes[4] = attributes[5] = constant
            termios.tcsetattr(self._tty, termios.TCSANOW, attributes)

    @abstractmethod
    def control(self, setup: Setup, data: bytes) -> bytes | None: ...


class CdcAcm(SerialFunction):
    """A communications device of the abstract control model: `/dev/ttyACMn`."""

    def __init__(self, line: Path, identity: Identity) -> None:
        super().__init__(line, identity)
        about = (
            usb.of_class(0x00, b"\x10\x01"),  # header
            usb.of_class(0x01, b"\x00\x01"),  # call management: none, data on interface 1
            usb.of_class(0x02, b"\x02"),  # it has a line coding
            usb.of_class(0x06, b"\x00\x01"),  # union of 0 and 1
        )
        control = usb.interface(0, (2, 2, 1), usb.endpoint(0x82, usb.INTERRUPT, 8, 255), extra=b"".join(about))
        data = usb.interface(
            1, (10, 0, 0), usb.endpoint(0x03, usb.BULK, self.packet), usb.endpoint(0x81, usb.BULK, self.packet)
        )
        self.configuration = usb.configuration(control, data, interfaces=2)
        self.dtr: list[bool] = []
        """Each change of "terminal ready": what a board that begins again at each opening goes by."""

    def control(self, setup: Setup, data: bytes) -> bytes | None:
        match setup.request:
            case 0x20:  # SET_LINE_CODING
                self._set_baud(struct.unpack_from("<I", data)[0])
                return b""
            case 0x21:
                return struct.pack("<IBBB", self.baud, 0, 0, 8)
            case 0x22:  # SET_CONTROL_LINE_STATE
                self.dtr.append(bool(setup.value & 1))
                return b""
            case 0x23:  # SEND_BREAK
                return b""
            case _:
                return None


class Ftdi(SerialFunction):
    """An FT232R: `/dev/ttyUSBn`. It keeps what it hears for `latency_ms`, unless there is a packet full of it."""

    STATUS = b"\x01\x60"
    """Begins each packet: nothing of the modem, the transmitter is empty."""

    def __init__(self, line: Path, identity: Identity) -> None:
        super().__init__(line, identity)
        ends = usb.endpoint(0x81, usb.BULK, self.packet), usb.endpoint(0x02, usb.BULK, self.packet)
        self.configuration = usb.configuration(usb.interface(0, (255, 255, 255), *ends), interfaces=1)
        self.latency_ms = 16
        self.asked_latency_ms: list[int] = []

    def control(self, setup: Setup, data: bytes) -> bytes | None:
        match setup.request:
            case 0:  # RESET, at each opening: what came before is forgotten
                termios.tcflush(self._tty, termios.TCIFLUSH)
            case 3:  # SET_BAUDRATE
                self._set_baud(rate(setup.value, setup.index))
            case 5:  # GET_MODEM_STATUS
                return self.STATUS
            case 9:  # SET_LATENCY_TIMER
                self.latency_ms = setup.value & 0xFF
                self.asked_latency_ms.append(self.latency_ms)
            case 10:
                return bytes((self.latency_ms,))
            case 0x90:  # READ_EEPROM
                return b"\xff\xff"
        return b""

    def come(self, room: int) -> bytes:
        pieces = []
        while room > len(self.STATUS):
            data = super().come(min(room, self.packet) - len(self.STATUS))
            if not data:
                break
            pieces.append(self.STATUS + data)
            room -= self.packet
            if len(data) < self.packet - len(self.STATUS):
                break
        self._again_at = time.monotonic() + max(self.pause_s, self.latency_ms * 1e-3)
        return b"".join(pieces)


_EIGHTHS = (0, 4, 2, 1, 3, 5, 6, 7)
"""What the three bits of a divisor's fraction stand for."""


def rate(value: int, index: int) -> int:
    """Return the baud rate that an FT232R's divisor means: 3 MHz by whole and eighths; 0 and 1 are 3 and 2 MHz."""
    whole, fraction = value & 0x3FFF, _EIGHTHS[value >> 14 | (index & 1) << 2]
    if not fraction and whole < 2:
        return (3_000_000, 2_000_000)[whole]
    return round(3_000_000 * 8 / max(1, whole * 8 + fraction))


def divisor(baud: int) -> tuple[int, int]:
    """Return the divisor's value and index that the kernel's driver asks for, by FTDI's application note AN232B-05."""
    eighths = (3_000_000 * 8 + baud // 2) // baud
    if eighths in {8, 12}:
        return {8: (0, 0), 12: (1, 0)}[eighths]
    code = _EIGHTHS.index(eighths & 7)
    return eighths >> 3 | (code & 3) << 14, code >> 2
