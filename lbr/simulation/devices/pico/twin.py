"""The emulated UPS PIco on an i2c bus of its own, fed by the world's battery."""

from collections.abc import Mapping

from lbr.capability.context import Device
from lbr.simulation.devices.pico import PicoFaults, PicoRow
from lbr.simulation.devices.pico.device import Pico
from lbr.simulation.i2c import I2cDevice
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.i2c import I2cTwin


class PicoTwin(I2cTwin[PicoFaults]):
    """Reports the voltage of the world's battery, unless a fault sets another."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, PicoRow)
        super().__init__(device.name, device.address, settings.faults, around.seed_for(device) + 1)
        self._address = settings.i2c_address
        self._relay_on = settings.relay_on
        self._supply = Pico(settings.battery_v, settings.temperature_c, settings.faults)
        self._supply.relay = settings.relay_on

    @property
    def motors_on(self) -> bool:
        """Return whether the relay gives the servos power."""
        return self._supply.relay == self._relay_on

    def sense(self, sensed: Sensed) -> None:
        """Set the voltage that feeds it."""
        self._supply.external_v = sensed.battery_v

    def take_over(self) -> None:
        """Pass the present faults to the supply."""
        if self._supply.faults is not self._faults:
            self._supply.faults = self._faults

    def devices(self) -> Mapping[int, I2cDevice]:
        """Return the devices on the bus: status and commands."""
        return self._supply.on_bus(self._address)
