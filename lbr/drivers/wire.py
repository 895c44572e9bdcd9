"""A tty for short transactions: bytes out at once, bytes in within a time. No protocol."""

import os
import select
import termios
from math import ceil

from lbr.capability.tap import Tap
from lbr.drivers.serial_line import SerialLine
from lbr.errors import DeviceError

BITS_PER_BYTE = 10
READ_BYTES = 4096


class Wire:
    """An open tty: never spins, and every failure is a DeviceError in words for people."""

    def __init__(self, fd: int, name: str, baud: int, *, line: SerialLine | None = None) -> None:
        self.name = name
        self.baud = baud
        self._fd = fd
        self._line = line  # keeps the lock, and closes
        self._tap = line.tap if line is not None else Tap()
        poll = select.poll()
        poll.register(fd, select.POLLIN)
        self._wait = poll.poll

    def fileno(self) -> int:
        """The open descriptor."""
        return self._fd

    def send(self, data: bytes) -> bool:
        """Write all of it at once; False when the line takes no more, which then has lost what it held."""
        try:
            if os.write(self._fd, data) == len(data):
                self._tap.sent(data)
                return True
        except BlockingIOError:
            pass
        except OSError as err:
            raise self._line_lost(err) from err
        self.drop_output()
        return False

    def receive(self, wait_s: float) -> bytes:
        """Return what has come in, waiting for the first byte for `wait_s` at most; empty if nothing has."""
        try:
            if not self._wait(ceil(wait_s * 1000.0) if wait_s > 0.0 else 0):
                return b""
            data = os.read(self._fd, READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError as err:
            raise self._line_lost(err) from err
        if not data:
            raise self._line_lost(None)
        self._tap.came(data)
        return data

    def wire_s(self, count: int) -> float:
        """Return how long this many bytes take on the wire."""
        return count * BITS_PER_BYTE / self.baud

    def drop_output(self) -> None:
        """Throw away what was written and has not left yet."""
        try:
            termios.tcflush(self._fd, termios.TCOFLUSH)
        except (OSError, termios.error) as err:  # the latter is not an OSError
            raise self._line_lost(err) from err

    def close(self) -> None:
        """Close the line; never fails."""
        if self._line is not None:
            self._line.close()

    def _line_lost(self, err: BaseException | None) -> DeviceError:
        number = next((value for value in err.args if isinstance(value, int)), None) if err else None
        cause = os.strerror(number) if number is not None else "end of file"
        return DeviceError(f"the servo line {self.name} went away ({cause}); check the adapter's cable and power")
