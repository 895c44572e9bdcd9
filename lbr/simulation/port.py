"""A pseudo-terminal in place of a device's tty, under a name that stays the same when it is plugged in again."""

import errno
import fcntl
import os
import struct
import tty
from pathlib import Path
from typing import Self

from lbr.errors import DeviceError

_READ_BYTES = 4096
_TCGETS2 = 0x802C542A
_TERMIOS2 = struct.Struct("=4I20s2I")
"""The kernel's `struct termios2`: flags, line discipline and control characters, rates of input and output."""


class PtyPort:
    """The device's end of a tty at `path`; never blocks, and keeps the tty open between clients."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._master: int | None = None
        self._keeper: int | None = None
        self._target = ""

    def __enter__(self) -> Self:
        self.plug()
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    @property
    def plugged(self) -> bool:
        """Return whether clients can open the path."""
        return self._master is not None

    def fileno(self) -> int:
        """Return the descriptor to select on; raise DeviceError while unplugged."""
        if self._master is None:
            raise DeviceError(f"emulated port {self.path}: it is unplugged")
        return self._master

    def plug(self) -> None:
        """Make the tty, in raw mode before it has a name, and link the path to it; raise DeviceError if that is
        taken."""
        if self._master is not None:
            return
        if self.path.exists() and not self.path.is_symlink():
            raise DeviceError(f"emulated port {self.path}: something else is there; remove it or change the address")
        self._master, self._keeper = os.openpty()
        try:
            tty.setraw(self._keeper)
            os.set_blocking(self._master, False)
            self._target = os.ttyname(self._keeper)
            self._link()
        except OSError as err:
            self.unplug()
            raise DeviceError(f"emulated port {self.path}: {err.strerror or err}; can this path be written?") from err

    def unplug(self) -> None:
        """Remove the tty and its name; clients see the same as with a pulled cable."""
        if self._target and self.path.is_symlink() and str(self.path.readlink()) == self._target:
            self.path.unlink(missing_ok=True)
        for descriptor in (self._master, self._keeper):
            if descriptor is not None:
                os.close(descriptor)
        self._master = self._keeper = None
        self._target = ""

    def baud(self) -> int:
        """Return the rate that the client set; 0 while unplugged."""
        if self._master is None:
            return 0
        return int(_TERMIOS2.unpack(fcntl.ioctl(self._master, _TCGETS2, bytes(_TERMIOS2.size)))[-1])

    def read(self) -> bytes:
        """Return bytes from clients, empty without any."""
        if self._master is None:
            return b""
        try:
            return os.read(self._master, _READ_BYTES)
        except OSError as err:
            if err.errno in {errno.EAGAIN, errno.EIO}:
                return b""
            raise

    def write(self, data: bytes) -> int:
        """Send to the clients and return the number of sent bytes; the rest is lost, as with a device's full buffer."""
        if self._master is None:
            return 0
        try:
            return os.write(self._master, data)
        except BlockingIOError:
            return 0

    def _link(self) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        fresh = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        fresh.unlink(missing_ok=True)
        fresh.symlink_to(self._target)
        fresh.replace(self.path)
