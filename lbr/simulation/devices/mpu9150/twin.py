"""The emulated MPU-9150 on an i2c bus of its own."""

from collections.abc import Mapping

from lbr.capability.context import Device
from lbr.simulation.devices.mpu9150 import Mpu9150Faults, Mpu9150Row
from lbr.simulation.devices.mpu9150.device import Mpu9150
from lbr.simulation.i2c import I2cDevice
from lbr.simulation.measured import ImuReading
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.i2c import I2cTwin


class Mpu9150Twin(I2cTwin[Mpu9150Faults]):
    """Follows each step of the world."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, Mpu9150Row)
        super().__init__(device.name, device.address, settings.faults, around.seed_for(device) + 1)
        self._address = settings.i2c_address
        self._chip = Mpu9150(seed=around.seed_for(device), sensitivity=settings.sensitivity)

    def take_over(self) -> None:
        """Pass the present faults to the chip."""
        if self._chip.faults is not self._faults:
            self._chip.faults = self._faults

    def devices(self) -> Mapping[int, I2cDevice]:
        """Return the devices on the bus: the chip, and its compass through the bypass."""
        return self._chip.on_bus(self._address)

    def feel(self, reading: ImuReading, now: float) -> None:
        """Set its present measurements."""
        self._chip.feel(reading, now)
