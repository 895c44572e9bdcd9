"""The wire of a servo bus: one request out, bytes back within a time that follows from their number. No protocol."""

from lbr.capability.context import Device
from lbr.drivers.serial_line import SerialLine, open_line
from lbr.drivers.wire import Wire

SERVO_S = 0.0003
"""The time until a servo begins its answer, and the hole in it that its motor control makes (datasheet and measured).
"""
LONGEST_DELAY_S = 0.000508
"""The largest return delay time a servo can be set to."""


class ServoLine(Wire):
    """An open tty for short transactions."""

    def __init__(self, fd: int, name: str, baud: int, *, margin_s: float, line: SerialLine | None = None) -> None:
        super().__init__(fd, name, baud, line=line)
        self.margin_s = margin_s

    def busy_s(self, sent_bytes: int, back_bytes: int, servos: int = 1) -> float:
        """Return how long a transaction takes at most: the wire both ways, and the servos' own time."""
        return self.wire_s(sent_bytes + back_bytes) + servos * (SERVO_S + LONGEST_DELAY_S)


def open_servo_line(device: Device, baud: int, margin_s: float) -> ServoLine:
    """Open the line of a device row for this process alone."""
    line = open_line(device, baud)
    line.low_latency()
    return ServoLine(line.fileno(), f"'{device.name}' at {line.path}", baud, margin_s=margin_s, line=line)
