"""A node of the kernel's input, such as /dev/input/event0 or /dev/lirc0, as an open file; reads never wait."""

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
"""The errors with which anything but an input device, such as an emulated one, answers an input device's requests."""


class InputNode(Generic[R]):
    """An open input node; a DeviceError names the device row, the path and the cure when it is missing or goes away.

    An empty path means that the device was not found.
    """

    def __init__(self, device: Device, path: str, parser: RecordParser[R]) -> None:
        self._device = device
        self._parser = parser
        self._fd = self._open(path)
        device.tap.opened()
        with suppress(termios.error):  # an emulated device is a tty
            termios.tcflush(self._fd, termios.TCIFLUSH)

    @property
    def passed_over(self) -> int:
        """Return how many bytes belonged to no record."""
        return self._parser.passed_over

    def poll(self) -> list[R]:
        """Return the records received since the last call."""
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
        """Return the answer to a request, of `answer` bytes; None if the device does not support the request."""
        try:
            return fcntl.ioctl(self._fd, request, bytes(answer))
        except OSError as err:
            if err.errno in UNKNOWN:
                return None
            raise self.error(f"went away ({err.strerror}); check its cable") from err

    def order(self, request: int, argument: bytes | int) -> None:
        """Send a request that changes the device; raise OSError if it fails."""
        fcntl.ioctl(self._fd, request, argument)

    def claim(self) -> None:
        """Keep its events from all other readers, and date them by the monotonic clock."""
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
        """Return the DeviceError for this device."""
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
