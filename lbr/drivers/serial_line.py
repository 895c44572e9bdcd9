"""A serial line held by one driver alone: found by a stable name, opened exclusively, never blocking. No protocol."""

import fcntl
import os
import re
import select
import termios
from collections.abc import Callable
from contextlib import suppress
from glob import glob
from pathlib import Path
from typing import TypeVar

import serial
from serial.tools import list_ports

from lbr.capability.context import Device
from lbr.capability.tap import Tap
from lbr.drivers import access
from lbr.errors import DeviceError

BY_ID = "/dev/serial/by-id"
READ_BYTES = 4096
BITS_PER_BYTE = 10


class SerialLine:
    """An open tty. Every failure is a DeviceError that names the device row, the path and the cure.

    A guard has no `port`, only the descriptor that it was given.
    """

    def __init__(
        self, fd: int, name: str, baud: int, *, tap: Tap | None = None, port: serial.Serial | None = None
    ) -> None:
        self.name = name
        self.baud = baud
        self._fd = fd
        self._tap = tap or Tap()
        self._port = port
        poll = select.poll()
        poll.register(fd, select.POLLIN)
        self._wait = poll.poll

    def fileno(self) -> int:
        """The open descriptor."""
        return self._fd

    def read(self, wait_s: float = 0.0) -> bytes:
        """Return the received bytes, waiting for the first for `wait_s` at most, and else nothing."""
        try:
            if not self._wait(wait_s * 1000.0 if wait_s > 0.0 else 0):
                return b""
            data = os.read(self._fd, READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError as err:
            raise self._line_lost(f"cannot be read: {_cause(err)}") from err
        if not data:
            raise self._line_lost("end of file")
        self._tap.came(data)
        return data

    def write(self, data: bytes) -> int:
        """Write as much as the line takes at once; return how many bytes that was. Never waits."""
        try:
            written = os.write(self._fd, data)
        except BlockingIOError:
            return 0
        except OSError as err:
            raise self._line_lost(f"cannot be written: {_cause(err)}") from err
        self._tap.sent(data[:written])
        return written

    def send(self, data: bytes) -> bool:
        """Write all of it at once; return False if the line takes no more, and discard its pending output."""
        if self.write(data) == len(data):
            return True
        self.drop_output()
        return False

    def wire_s(self, count: int) -> float:
        """Return how long this many bytes take on the wire."""
        return count * BITS_PER_BYTE / self.baud

    def set_baud(self, baud: int) -> None:
        """Change the speed; the line stays open, so that a board that resets at each opening does not."""
        assert self._port is not None
        try:
            self._port.baudrate = baud
        except ValueError as err:
            raise DeviceError(f"{self.name} cannot be read at {baud} baud: {err}") from err
        except (OSError, termios.error) as err:
            raise self._line_lost(f"cannot be set to {baud} baud: {_cause(err)}") from err

    def low_latency(self) -> None:
        """Make the kernel deliver input at once, where the line supports it: some adapters wait for 16 ms."""
        assert self._port is not None
        with suppress(OSError, ValueError, termios.error):
            self._port.set_low_latency_mode(True)

    def drop_output(self) -> None:
        """Discard the output that has not left yet."""
        self._flush(termios.TCOFLUSH)

    def drop_input(self) -> None:
        """Discard the input that was not read yet."""
        self._flush(termios.TCIFLUSH)

    def close(self) -> None:
        """Close the line; never fails. The kernel closes a guard's line."""
        if self._port is not None:
            with suppress(OSError, termios.error):
                self._port.close()

    def _flush(self, queue: int) -> None:
        try:
            termios.tcflush(self._fd, queue)
        except (OSError, termios.error) as err:  # the latter is not an OSError
            raise self._line_lost(f"cannot be flushed: {_cause(err)}") from err

    def _line_lost(self, cause: str) -> DeviceError:
        return DeviceError(f"{self.name} went away ({cause}); check its cable and power")


L = TypeVar("L", bound=SerialLine)


def open_line(device: Device, baud: int) -> SerialLine:
    """Open the line of a device row for this process alone."""
    return opened(device, baud, SerialLine)


def opened(device: Device, baud: int, line: Callable[..., L]) -> L:
    """Open the line of a device row as `line`, a subclass."""
    path = resolve(device)
    try:
        port = serial.Serial(path, baudrate=baud, timeout=0, write_timeout=0, exclusive=True)
    except (OSError, termios.error, ValueError) as err:
        raise DeviceError(_why_not(device.name, path, err), access.code_of(err)) from err
    if not os.path.realpath(path).startswith("/dev/pts/"):  # there the flag would outlive a killed driver
        with suppress(OSError):
            fcntl.ioctl(port.fileno(), termios.TIOCEXCL)
    device.tap.opened()
    return line(port.fileno(), f"device '{device.name}' at {path}", baud, tap=device.tap, port=port)


def resolve(device: Device, ports: Callable[[], list[tuple[str, int | None, int | None, str]]] | None = None) -> str:
    """Return the path for an address: a path, `usb:VID:PID[:SERIAL]`, or `by-id:GLOB`."""
    address = device.address
    if address.startswith("/"):
        return address
    if usb := _USB.fullmatch(address):
        paths = _matching_usb(usb, (ports or _usb_ports)())
    elif address.startswith("by-id:"):
        paths = sorted(glob(f"{BY_ID}/{address.removeprefix('by-id:')}"))  # noqa: PTH207  a pattern, from a row
    else:
        raise DeviceError(
            f"device '{device.name}': address '{address}' is not one of a path (/dev/...), "
            "usb:VID:PID[:SERIAL], by-id:GLOB"
        )
    return _only_one(device, paths)


def _only_one(device: Device, paths: list[str]) -> str:
    if not paths:
        raise DeviceError(f"device '{device.name}': nothing matches {device.address}; plug it in, or see {BY_ID}")
    if len(paths) > 1:
        raise DeviceError(
            f"device '{device.name}': {device.address} matches {', '.join(paths)}; make the address say which"
        )
    return paths[0]


def _usb_ports() -> list[tuple[str, int | None, int | None, str]]:
    return [(port.device, port.vid, port.pid, port.serial_number or "") for port in list_ports.comports()]


def _matching_usb(usb: re.Match[str], ports: list[tuple[str, int | None, int | None, str]]) -> list[str]:
    vendor, product, number = int(usb[1], 16), int(usb[2], 16), usb[3]
    return sorted(path for path, vid, pid, own in ports if (vid, pid) == (vendor, product) and number in (None, own))


def _why_not(device: str, path: str, err: Exception) -> str:
    line = f"device '{device}' at {path}"
    # pyserial words its refusals its own way, but keeps the errno, or the error that it was raised from
    first = err.__context__ if isinstance(err.__context__, termios.error) else None
    match getattr(err, "errno", None) or (first.args[0] if first is not None else None):
        case 21 | 25:
            return f"{line} is no serial line; correct the address in the device row"
        case 2 | 6 | 19:
            return f"{line} is missing; plug it in, or correct the address in the device row"
        case 13:
            return f"{line} {access.refused(path, 'dialout')}"
        case 11 | 16:
            return f"{line} is busy{holder(path)}; stop the other program"
        case _:
            return f"{line} cannot be opened: {_cause(err)}"


def holder(path: str) -> str:
    """Return `: held by PROGRAM (pid N)`, the owner of a tty's lock, or an empty string; the tty is not opened."""
    try:
        stat = Path(path).stat()
        node = f"{os.major(stat.st_dev):02x}:{os.minor(stat.st_dev):02x}:{stat.st_ino}"
        locks = Path("/proc/locks").read_text().splitlines()
        owners = {line.split()[4] for line in locks if " FLOCK " in line and line.split()[5] == node}
        names = [f"{Path(f'/proc/{pid}/comm').read_text().strip()} (pid {pid})" for pid in sorted(owners)]
    except (OSError, IndexError):
        return ""
    return f": held by {', '.join(names)}" if names else ""


def _cause(err: BaseException) -> str:
    number = next((value for value in err.args if isinstance(value, int)), None)
    return os.strerror(number) if number is not None else str(err)


_USB = re.compile(r"usb:([0-9a-fA-F]{4}):([0-9a-fA-F]{4})(?::(.+))?")
