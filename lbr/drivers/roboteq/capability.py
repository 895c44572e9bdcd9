"""The Roboteq controller as the capability that drives two wheels."""

from collections.abc import Callable

from lbr.capability.context import Device
from lbr.drivers.roboteq import RoboteqSettings
from lbr.drivers.roboteq.controller import Controller
from lbr.drivers.serial_line import open_line
from lbr.drivers.wheels.capability import Wheels


class Roboteq(Wheels[RoboteqSettings]):
    """Two wheels on a Roboteq."""

    def connect(self, device: Device, beat: Callable[[], None]) -> Controller:
        """Open its serial line."""
        return Controller(open_line(device, self.ctx.settings.baud), self.ctx.settings, self.ctx.clock, beat)
