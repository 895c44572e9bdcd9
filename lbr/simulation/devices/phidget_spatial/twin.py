"""The emulated PhidgetSpatial at its socket."""

from lbr.capability.context import Device
from lbr.simulation.devices.phidget_spatial import PhidgetSpatialFaults, PhidgetSpatialRow
from lbr.simulation.devices.phidget_spatial.device import PhidgetSpatial
from lbr.simulation.measured import ImuReading
from lbr.simulation.socket_port import SocketPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row


class PhidgetSpatialTwin(PortTwin[SocketPort, PhidgetSpatialFaults]):
    """Serves one client, as a cable does: the next one replaces it."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, PhidgetSpatialRow)
        super().__init__(device.name, SocketPort(device.address), settings.faults)
        self._unit = PhidgetSpatial(now=around.now, burst=settings.burst)
        self._client = -1

    def service(self, now: float) -> None:
        """Do all that is due: the cable, orders in, records out."""
        self._unit.faults = self._faults
        if plug(self.port, present=not self._faults.unplug):
            self._client = -1
        if not self.port.plugged:
            return
        for client, data in self.port.receive():
            if client not in self.port.clients:
                continue
            if client != self._client:
                self.port.drop(self._client)
                self._client = client
                self._unit.plugged_in()
            self._unit.receive(data, now)
        records = self._unit.records(now)
        if records and self.port.send(self._client, records) < len(records):
            self.port.drop(self._client)  # it reads nothing: records could no longer be separated

    def next_due(self) -> float | None:
        """Return when the next records are due."""
        return self._unit.next_due() if self._client in self.port.clients else None

    def feel(self, reading: ImuReading, now: float) -> None:  # noqa: ARG002 - its records are dated when they are due
        """Set its present measurements."""
        self._unit.feel(reading)
