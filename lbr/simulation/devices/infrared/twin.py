"""The emulated infrared receiver on its port."""

from lbr.capability.context import Device
from lbr.simulation.devices.infrared import InfraredFaults, InfraredRow
from lbr.simulation.devices.infrared.device import InfraredReceiver
from lbr.simulation.measured import Sensed
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row


class InfraredTwin(PortTwin[PtyPort, InfraredFaults]):
    """Says which of the dock's beams it sees."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, InfraredRow)
        super().__init__(device.name, PtyPort(device.address), settings.faults)
        self._receiver = InfraredReceiver(
            settings.codes.numbers(),
            protocol=settings.protocol,
            faults=settings.faults,
            seed=around.seed_for(device),
        )

    def service(self, now: float) -> None:
        """Do all that is due: the cable, records out."""
        self._receiver.faults = self._faults
        plug(self.port, present=not self._faults.unplug)
        self.port.read()
        said = self._receiver.poll(now)
        if said:
            self.port.write(said)

    def next_due(self) -> float | None:
        """Return when it next has something to say."""
        return self._receiver.next_due()

    def sense(self, sensed: Sensed) -> None:
        """See what shines."""
        self._receiver.beams = sensed.beams
