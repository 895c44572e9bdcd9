"""The emulated RIOX on its port."""

from lbr.capability.context import Device
from lbr.simulation.devices.riox import RioxFaults, RioxRow
from lbr.simulation.devices.riox.device import RioxDevice
from lbr.simulation.measured import ImuReading
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin


class RioxTwin(LineTwin[RioxFaults]):
    """Answers questions about turn, tilt and field."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, RioxRow)
        self._device = RioxDevice(settings, seed=around.seed_for(device))
        super().__init__(device, settings.faults, self._device)

    def present(self, now: float) -> bool:
        """Return whether the host sees the port."""
        return self._device.present(now)

    def hear(self, data: bytes, now: float) -> bytes:
        """Receive bytes; return the bytes that have crossed the line back."""
        return self._device.feed(data, now)

    def feel(self, reading: ImuReading, now: float) -> None:
        """Set its present measurements."""
        self._device.feel(reading, now)
