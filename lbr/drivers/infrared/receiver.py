"""The kernel's remote control input as an open file: /dev/lircN, an input event, or an emulated one."""

import errno
import fcntl
import os
import struct
import termios
from contextlib import suppress
from pathlib import Path

from lbr.capability.context import Device
from lbr.drivers import access
from lbr.drivers.infrared import InfraredSettings, decoders
from lbr.drivers.infrared.records import RecordParser, Scancode, read_event, read_scancode
from lbr.errors import DeviceError
from lbr.messages.codes import Code

READ_BYTES = 24 * 64
LIRC_SET_REC_MODE, LIRC_MODE_SCANCODE = 0x40046912, 8
EVIOCGRAB, EVIOCSCLOCKID, CLOCK_MONOTONIC = 0x40044590, 0x400445A0, 1
UNKNOWN = (errno.ENOTTY, errno.EINVAL, errno.ENOSYS)


class Receiver:
    """Raises a DeviceError that names the device row, the path and what to do, when it is missing or goes away."""

    def __init__(self, device: Device, settings: InfraredSettings) -> None:
        self._device = device
        events = _sends_events(device.address, settings)
        self._parser = RecordParser(read_event if events else read_scancode)
        self._fd = self._open()
        device.tap.opened()
        try:
            self._prepare_events() if events else self._prepare_scancodes()
            self._refuse_without_decoder(settings)
        except BaseException:  # also an interruption leaves nothing open; it goes on upwards
            self.close()
            raise

    @property
    def passed_over(self) -> int:
        """Return how many bytes were no part of a record."""
        return self._parser.passed_over

    def poll(self) -> list[Scancode]:
        """Return what has come in since the last call."""
        try:
            data = os.read(self._fd, READ_BYTES)
        except BlockingIOError:
            self._parser.pause()
            return []
        except OSError as err:
            raise self._error(f"went away ({err.strerror}); check its cable") from err
        if not data:
            raise self._error("went away (end of file); check its cable")
        self._device.tap.came(data)
        return self._parser.feed(data)

    def close(self) -> None:
        """Close the device; never fails."""
        with suppress(OSError):
            os.close(self._fd)

    def _open(self) -> int:
        path = self._device.address
        if not path.startswith("/"):
            raise self._error("is not a path; write /dev/lirc0 or /dev/input/by-path/… into the device row")
        try:
            return os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
        except FileNotFoundError as err:
            raise self._error("is missing; plug it in, or correct the address in the device row") from err
        except PermissionError as err:
            raise self._error(access.refused(path), "rights") from err
        except OSError as err:
            busy = "; stop the other program" if err.errno == errno.EBUSY else ""
            raise self._error(f"cannot be opened: {err.strerror}{busy}", access.code_of(err)) from err

    def _prepare_scancodes(self) -> None:
        """Ask for decoded codes, not for pulses."""
        try:
            fcntl.ioctl(self._fd, LIRC_SET_REC_MODE, struct.pack("=I", LIRC_MODE_SCANCODE))
        except OSError as err:
            if err.errno == errno.EINVAL:
                raise self._error("decodes nothing; switch its protocol on with ir-keytable -p sony") from err
            if err.errno != errno.ENOTTY:
                raise self._error(f"cannot be set up: {err.strerror}") from err
            with suppress(termios.error):  # an emulated one is a tty
                termios.tcflush(self._fd, termios.TCIFLUSH)

    def _refuse_without_decoder(self, settings: InfraredSettings) -> None:
        """Refuse a receiver that decodes nothing we want: the kernel opens it all the same, and it hears nothing."""
        found = decoders.of(self._device.address)
        if lacks := found.lacks(settings.protocols) if found is not None else "":
            raise self._error(lacks)

    def _prepare_events(self) -> None:
        """Keep its keys from whatever has the keyboard, and have times by the clock that all of lbr goes by."""
        for request, argument in ((EVIOCSCLOCKID, struct.pack("=i", CLOCK_MONOTONIC)), (EVIOCGRAB, 1)):
            try:
                fcntl.ioctl(self._fd, request, argument)
            except OSError as err:
                if err.errno not in UNKNOWN:
                    raise self._error(f"belongs to another program ({err.strerror}); stop that", "busy") from err

    def _error(self, what: str, code: Code = "unreachable") -> DeviceError:
        return DeviceError(f"device '{self._device.name}' at {self._device.address} {what}", code)


def _sends_events(address: str, settings: InfraredSettings) -> bool:
    if settings.records == "auto":
        return any(path.startswith("/dev/input/") for path in (address, str(Path(address).resolve())))
    return settings.records == "events"
