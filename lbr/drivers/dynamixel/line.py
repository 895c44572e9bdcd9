"""The wire of a servo bus: one request out, bytes back within a time that follows from their number. No protocol."""

import os
import select
import termios
from math import ceil

from lbr.capability.context import Device
from lbr.drivers.serial_line import SerialLine, open_line
from lbr.errors import DeviceError

BITS_PER_BYTE = 10
SERVO_S = 0.0003
"""What a servo takes to begin its answer, and the hole in it that its motor control makes (datasheet and measured)."""
LONGEST_DELAY_S = 0.000508
"""The largest return delay time a servo can be set to."""
READ_BYTES = 4096


class ServoLine:
    """An open tty for short transactions: never spins, and every failure is a DeviceError in words for people."""

    def __init__(self, fd: int, name: str, baud: int, *, margin_s: float, line: SerialLine | None = None) -> None:
        self.name = name
        self.baud = baud
        self.margin_s = margin_s
        self._fd = fd
        self._line = line  # keeps the lock, and closes
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
                return True
        except BlockingIOError:
            pass
        except OSError as err:
            raise self._gone(err) from err
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
            raise self._gone(err) from err
        if not data:
            raise self._gone(None)
        return data

    def busy_s(self, sent_bytes: int, back_bytes: int, servos: int = 1) -> float:
        """Return how long a transaction takes at most: the wire both ways, and the servos' own time."""
        wire_s = (sent_bytes + back_bytes) * BITS_PER_BYTE / self.baud
        return wire_s + servos * (SERVO_S + LONGEST_DELAY_S)

    def drop_output(self) -> None:
        """Throw away what was written and has not left yet."""
        try:
            termios.tcflush(self._fd, termios.TCOFLUSH)
        except (OSError, termios.error) as err:  # the latter is not an OSError
            raise self._gone(err) from err

    def close(self) -> None:
        """Let go of the line; never fails."""
        if self._line is not None:
            self._line.close()

    def _gone(self, err: BaseException | None) -> DeviceError:
        number = next((value for value in err.args if isinstance(value, int)), None) if err else None
        cause = os.strerror(number) if number is not None else "end of file"
        return DeviceError(f"the servo line {self.name} went away ({cause}); check the adapter's cable and power")


def open_servo_line(device: Device, baud: int, margin_s: float) -> ServoLine:
    """Open the line of a device row for this process alone."""
    line = open_line(device, baud)
    line.low_latency()
    return ServoLine(line.fileno(), f"'{device.name}' at {line.path}", baud, margin_s=margin_s, line=line)
