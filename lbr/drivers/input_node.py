"""A node of the kernel's input, such as /dev/input/event0 or /dev/lirc0, as an open file that is read without
waiting."""

import errno
import fcntl
import os
import struct
import termios
from contextlib import suppress
from typing import Generic

from lbr.capability.context import Device
from lbr.drivers import access
from lbr.drivers.input_events import R, RecordParser
from lbr.errors import DeviceError
from lbr.messages.codes import Code

READ_BYTES = 24 * 64
EVIOCGRAB, EVIOCSCLOCKID, CLOCK_MONOTONIC = 0x40044590, 0x400445A0, 1
MISSING = "is missing; plug it in, or correct the address in the device row"
UNKNOWN = (errno.ENOTTY, errno.EINVAL, errno.ENOSYS)
"""The answers of anything but an input device, such as an emulated one, to questions for input devices."""


class InputNode(Generic[R]):
    """Raises a DeviceError that names the device row, the path and what to do, when it is missing or goes away.

    The path of what is nowhere is empty.
    """

    def __init__(self, device: Device, path: str, parser: RecordParser[R]) -> None:
        self._device = device
        self._parser = parser
        self._fd = self._open(path)
        device.tap.opened()
        with suppress(termios.error):  # an emulated one is a tty
            termios.tcflush(self._fd, termios.TCIFLUSH)

    @property
    def passed_over(self) -> int:
        """Return how many bytes were no part of a record."""
        return self._parser.passed_over

    def poll(self) -> list[R]:
        """Return the records that have come in since the last call."""
        try:
            data = os.read(self._fd, READ_BYTES)
        except BlockingIOError:
            self._parser.pause()
            return []
        except OSError as err:
            raise self.error(f"went away ({err.strerror}); check its cable") from err
        if not data:
            raise self.error("went away (end of file); check its cable")
        self._device.tap.came(data)
        return self._parser.feed(data)

    def ask(self, request: int, answer: int = 0) -> bytes | None:
        """Return what it answers to a request, in so many bytes; None if it knows no such request."""
        try:
            return fcntl.ioctl(self._fd, request, bytes(answer))
        except OSError as err:
            if err.errno in UNKNOWN:
                return None
            raise self.error(f"went away ({err.strerror}); check its cable") from err

    def order(self, request: int, argument: bytes | int) -> None:
        """Have it do something; raise OSError if it does not."""
        fcntl.ioctl(self._fd, request, argument)

    def claim(self) -> None:
        """Keep its keys from all other readers, and have times by the clock of lbr."""
        for request, argument in ((EVIOCSCLOCKID, struct.pack("=i", CLOCK_MONOTONIC)), (EVIOCGRAB, 1)):
            try:
                self.order(request, argument)
            except OSError as err:
                if err.errno not in UNKNOWN:
                    raise self.error(f"belongs to another program ({err.strerror}); stop that", "busy") from err

    def close(self) -> None:
        """Close it; never fails."""
        with suppress(OSError):
            os.close(self._fd)

    def error(self, what: str, code: Code = "unreachable") -> DeviceError:
        """Return what to raise."""
        return DeviceError(f"device '{self._device.name}' at {self._device.address} {what}", code)

    def _open(self, path: str) -> int:
        if not path:
            raise self.error(MISSING)
        try:
            return os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
        except FileNotFoundError as err:
            raise self.error(MISSING) from err
        except PermissionError as err:
            raise self.error(access.refused(path), "rights") from err
        except OSError as err:
            busy = "; stop the other program" if err.errno == errno.EBUSY else ""
            raise self.error(f"cannot be opened: {err.strerror}{busy}", access.code_of(err)) from err
