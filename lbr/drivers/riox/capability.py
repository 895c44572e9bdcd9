"""The RIOX as a capability: every answer becomes a sample, every missing answer an invalid one."""

from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.drivers.inertial import LifeSigns, Notices
from lbr.drivers.riox import RioxSettings
from lbr.drivers.riox.controller import AhrsUnit
from lbr.drivers.serial_line import open_line
from lbr.messages.imu import ImuSample

MOST_ALIKE = 25


class Riox(Capability[RioxSettings]):
    """Publishes what the inertial unit measures."""

    def __init__(self, ctx: Context[RioxSettings]) -> None:
        super().__init__(ctx)
        asked_for = 2 if ctx.settings.orientation else 1
        self.rate_hz = asked_for * ctx.settings.rate_hz
        self._notices = Notices(ctx)
        self._signs = LifeSigns(MOST_ALIKE)
        self._unit: AhrsUnit | None = None

    def open(self) -> None:
        """Open the line."""
        settings = self.ctx.settings
        line = open_line(self.device_row, settings.baud)
        self._unit = AhrsUnit(line, settings, self._notices.tell, self._signs, self.ctx.clock)
        self._unit.open()

    def step(self) -> None:
        """Publish the answers, and send the next query."""
        assert self._unit is not None
        for sample in self._unit.poll():
            self.ctx.publish("sample", sample)

    def answers(self) -> bool:
        """Return whether it has measured; an open line is not enough."""
        return self._unit is not None and self._unit.measured

    def degraded(self, reason: str) -> None:
        """Publish that nothing is measured."""
        self.ctx.publish("sample", ImuSample(valid=False, time_s=self.ctx.clock(), reason=reason))

    def close(self) -> None:
        """Close the line."""
        unit, self._unit = self._unit, None
        if unit is not None:
            unit.close()
