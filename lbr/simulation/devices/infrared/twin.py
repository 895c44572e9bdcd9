"""The emulated infrared receiver on its port."""

from lbr.capability.context import Device
from lbr.simulation.devices.infrared import InfraredFaults, InfraredRow
from lbr.simulation.devices.infrared.device import InfraredReceiver
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin


class InfraredTwin(LineTwin[InfraredFaults]):
    """Sends the codes of the visible beams of the dock."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, InfraredRow)
        self._receiver = InfraredReceiver(
            settings.codes.numbers(),
            protocol=settings.protocol,
            faults=settings.faults,
            seed=around.seed_for(device),
        )
        super().__init__(device, settings.faults, self._receiver)

    def sense(self, sensed: Sensed) -> None:
        """Set the visible beams."""
        self._receiver.beams = sensed.beams
