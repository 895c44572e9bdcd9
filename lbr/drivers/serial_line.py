"""A serial line held by one driver alone: found by a stable name, opened exclusively, never blocking."""

import fcntl
import os
import re
import select
import termios
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from glob import glob
from pathlib import Path

import serial
from serial.tools import list_ports

from lbr.capability.context import Device
from lbr.drivers import access
from lbr.errors import DeviceError

BY_ID = "/dev/serial/by-id"
READ_BYTES = 4096


class SerialLine:
    """An open tty. Every failure is a DeviceError that names the device row, the path and what to do."""

    def __init__(self, device: Device, path: str, port: serial.Serial) -> None:
        self.device = device.name
        self.path = path
        self.tap = device.tap
        self._port = port
        self._fd: int = port.fileno()
        self._poll = select.poll()
        self._poll.register(self._fd, select.POLLIN)

    def fileno(self) -> int:
        """The open descriptor."""
        return self._fd

    def read(self, wait_s: float = 0.0) -> bytes:
        """Return what has come in, waiting for the first byte for `wait_s` at most; empty if nothing has."""
        with self._telling("cannot be read"):
            if not self._poll.poll(max(0.0, wait_s) * 1000.0):
                return b""
            try:
                data = os.read(self._fd, READ_BYTES)
            except BlockingIOError:
                return b""
        if not data:
            raise self._line_lost("end of file")
        self.tap.came(data)
        return data

    def write(self, data: bytes) -> int:
        """Hand over what the line takes at once and return how much that was; never waits."""
        with self._telling("cannot be written"):
            try:
                written = os.write(self._fd, data)
            except BlockingIOError:
                return 0
            self.tap.sent(data[:written])
            return written

    def set_baud(self, baud: int) -> None:
        """Go on at another speed; the line stays open, so that a board that begins again at each opening does not."""
        try:
            self._port.baudrate = baud
        except ValueError as err:
            raise DeviceError(f"device '{self.device}' at {self.path} cannot be read at {baud} baud: {err}") from err
        except (OSError, termios.error) as err:
            raise self._line_lost(f"cannot be set to {baud} baud: {_cause(err)}") from err

    def low_latency(self) -> None:
        """Have the kernel hand over what comes in at once, where the line can: some adapters wait for 16 ms."""
        with suppress(OSError, ValueError, termios.error):
            self._port.set_low_latency_mode(True)

    def drop_output(self) -> None:
        """Throw away what was written and has not left yet."""
        with self._telling("cannot be flushed"):
            termios.tcflush(self._fd, termios.TCOFLUSH)

    def drop_input(self) -> None:
        """Throw away what has come in and was not read yet."""
        with self._telling("cannot be flushed"):
            termios.tcflush(self._fd, termios.TCIFLUSH)

    def close(self) -> None:
        """Close the line; never fails."""
        with suppress(OSError, termios.error):
            self._port.close()

    @contextmanager
    def _telling(self, trouble: str) -> Iterator[None]:
        try:
            yield
        except DeviceError:
            raise
        except (OSError, termios.error) as err:
            raise self._line_lost(f"{trouble}: {_cause(err)}") from err

    def _line_lost(self, cause: str) -> DeviceError:
        return DeviceError(f"device '{self.device}' at {self.path} went away ({cause}); check its cable and power")


def open_line(device: Device, baud: int) -> SerialLine:
    """Open the line of a device row for this process alone."""
    path = resolve(device)
    try:
        port = serial.Serial(path, baudrate=baud, timeout=0, write_timeout=0, exclusive=True)
    except (OSError, termios.error, ValueError) as err:
        raise DeviceError(_why_not(device.name, path, err), access.code_of(err)) from err
    if not os.path.realpath(path).startswith("/dev/pts/"):  # there the flag would outlive a killed driver
        with suppress(OSError):
            fcntl.ioctl(port.fileno(), termios.TIOCEXCL)
    device.tap.opened()
    return SerialLine(device, path, port)


def resolve(device: Device, ports: Callable[[], list[tuple[str, int | None, int | None, str]]] | None = None) -> str:
    """Return the path that an address means: a path, `usb:VID:PID[:SERIAL]`, or `by-id:GLOB`."""
    address = device.address
    if address.startswith("/"):
        return address
    if usb := _USB.fullmatch(address):
        paths = _matching_usb(usb, (ports or _usb_ports)())
    elif address.startswith("by-id:"):
        paths = sorted(glob(f"{BY_ID}/{address.removeprefix('by-id:')}"))  # noqa: PTH207  a pattern, from a row
    else:
        raise DeviceError(
            f"device '{device.name}': address '{address}' is not one of a path (/dev/...), usb:VID:PID[:SERIAL], by-id:GLOB"
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
    # pyserial words its refusals its own way, but keeps the number, or what it was raised from
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
    """Return `: held by PROGRAM (pid N)`, the process that holds the lock on a tty, as far as the kernel tells; it is
    not opened."""
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
