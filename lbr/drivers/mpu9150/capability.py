"""The MPU-9150 as a capability: one reading at each tick, an invalid sample if nothing was measured.

While it lies still the ticks are fewer, and some readings are one sample. A reading of a motion is published at once
and restores the full rate.
"""

from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.drivers.i2c import open_bus
from lbr.drivers.inertial import QUIET_HZ, LifeSigns, Notices, Quiet, RestingSamples
from lbr.drivers.mpu9150 import Mpu9150Settings
from lbr.drivers.mpu9150.controller import InertialUnit
from lbr.drivers.mpu9150.registers import ADDRESS
from lbr.messages.imu import ImuSample

MOST_ALIKE = 10


class Mpu9150(Capability[Mpu9150Settings]):
    """Publishes what the inertial unit measures."""

    def __init__(self, ctx: Context[Mpu9150Settings]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.rate_hz
        self._notices = Notices(ctx)
        self._signs = LifeSigns(MOST_ALIKE)
        self._quiet = Quiet(ctx.settings.still_rps, ctx.settings.still_mps2)
        self._resting = RestingSamples()
        self._unit: InertialUnit | None = None
        self._compass_trouble = ""

    def open(self) -> None:
        """Open the bus and start the unit."""
        device, settings, tell = self.device_row, self.ctx.settings, self._notices.tell
        bus, address = open_bus(device, ADDRESS)
        self._unit = InertialUnit(bus, address, device, settings, tell, self._signs, self.ctx.clock)
        self._unit.start()
        self._resting = RestingSamples()
        self._compass_trouble = ""

    def step(self) -> None:
        """Measure and publish."""
        unit = self._unit
        assert unit is not None
        if not self.ctx.on_tick:
            return
        reading = unit.sample()
        quiet, full_hz = self._quiet.look(reading), self.ctx.settings.rate_hz
        for sample in self._resting.take(reading, quiet=quiet):
            self.ctx.publish("sample", sample)
        self.rate_hz = min(full_hz, QUIET_HZ) if quiet else full_hz
        unit.rest(rests=quiet)
        if unit.compass_trouble != self._compass_trouble:
            self._compass_trouble = unit.compass_trouble
            if self._compass_trouble:
                self.ctx.warn(f"no compass: {self._compass_trouble}", "unreachable")
            else:
                self.ctx.ready()

    def degraded(self, reason: str) -> None:
        """Publish that nothing is measured."""
        self.ctx.publish("sample", ImuSample(valid=False, time_s=self.ctx.clock(), reason=reason))

    def close(self) -> None:
        """Close the bus."""
        unit, self._unit = self._unit, None
        if unit is not None:
            unit.close()
