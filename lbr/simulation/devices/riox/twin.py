"""The emulated RIOX on its port."""

from lbr.capability.context import Device
from lbr.simulation.devices.riox import RioxFaults, RioxRow
from lbr.simulation.devices.riox.device import RioxDevice
from lbr.simulation.measured import ImuReading, Sensed
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row


class RioxTwin(PortTwin[PtyPort, RioxFaults]):
    """Answers what it is asked about turn, tilt and field."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, RioxRow)
        super().__init__(device.name, PtyPort(device.address), settings.faults)
        self._device = RioxDevice(settings, seed=around.seed_for(device))

    def watched(self) -> int | None:
        """Return the descriptor whose bytes it will take; None: none now."""
        return None if self._device.faults.stop_reading else super().watched()

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""
        if self._device.faults is not self._faults:
            self._device.faults = self._faults
        plug(self.port, present=self._device.present(now))
        heard = b"" if self._device.faults.stop_reading else self.port.read()
        answer = self._device.feed(heard, now) if heard else self._device.poll(now)
        if answer:
            self.port.write(answer)

    def next_due(self) -> float | None:
        """Return when it next has something to do by itself."""
        return self._device.next_due()

    def sense(self, sensed: Sensed) -> None:
        """Nothing: it feels each step of the world."""

    def feel(self, reading: ImuReading, now: float) -> None:
        """Take in what it measures now."""
        self._device.feel(reading, now)
