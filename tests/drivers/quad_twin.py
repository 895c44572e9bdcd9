"""The emulated controller of four motors: it takes `P A B C D`, tells counts, and stops when it hears nothing."""

import re

from msgspec import Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import Faults
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, plug, row

MOTORS = ("front_left", "front_right", "rear_left", "rear_right")
POWERS = re.compile(rb"P (-?\d+) (-?\d+) (-?\d+) (-?\d+)")
WATCHDOG_S = 0.2


class QuadFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What can go wrong with it."""


class QuadRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What its device row may set."""

    faults: QuadFaults = QuadFaults()


class QuadTwin(PortTwin[PtyPort, QuadFaults]):
    """Four motors on a port."""

    def __init__(self, device, around):
        super().__init__(device.name, PtyPort(device.address), row(device, QuadRow).faults)
        self._heard, self._powers, self._fed = b"", (0,) * 4, around.now
        self._counts = (0,) * 4

    def service(self, now):
        plug(self.port, present=not self._faults.unplug)
        *lines, self._heard = (self._heard + self.port.read()).split(b"\r")
        for line in lines:
            if found := POWERS.fullmatch(line):
                self._powers, self._fed = tuple(map(int, found.groups())), now
                self.port.write(b"C %d %d %d %d ok\r" % self._counts)

    def next_due(self):
        return None

    def motors(self, now):
        powers = self._powers if now - self._fed < WATCHDOG_S else (0,) * 4
        return {motor: power / 1000 for motor, power in zip(MOTORS, powers, strict=True)}

    def sense(self, sensed):
        self._counts = tuple(sensed.motors[motor].counts for motor in MOTORS)


TWIN = DeviceTwin(device="quad", row=QuadRow, entry=QuadTwin)
