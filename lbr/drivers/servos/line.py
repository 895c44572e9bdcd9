"""The line of a servo bus: one request out, bytes back within a time that follows from their number. No protocol."""

from functools import partial
from typing import Any

from lbr.capability.context import Device
from lbr.drivers.serial_line import SerialLine, opened

SERVO_S = 0.0003
"""The time until a servo begins its answer, plus the gap that its motor control makes in it (datasheet and measured).
"""
LONGEST_DELAY_S = 0.000508
"""The largest return delay time that a servo can have."""


class ServoLine(SerialLine):
    """An open tty for short transactions."""

    def __init__(self, fd: int, name: str, baud: int, *, margin_s: float, **rest: Any) -> None:
        super().__init__(fd, name, baud, **rest)
        self.margin_s = margin_s

    def busy_s(self, sent_bytes: int, back_bytes: int, servos: int = 1) -> float:
        """Return the longest time of a transaction: the wire both ways, and the servos' own time."""
        return self.wire_s(sent_bytes + back_bytes) + servos * (SERVO_S + LONGEST_DELAY_S)


def open_servo_line(device: Device, baud: int, margin_s: float) -> ServoLine:
    """Open the line of a device row for this process alone."""
    line = opened(device, baud, partial(ServoLine, margin_s=margin_s))
    line.low_latency()
    return line
