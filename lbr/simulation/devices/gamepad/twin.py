"""The emulated gamepad on its port."""

from collections import deque
from typing import Any

from lbr.capability.context import Device
from lbr.simulation.devices.gamepad import GamepadFaults, GamepadRow
from lbr.simulation.devices.gamepad.device import EmulatedGamepad
from lbr.simulation.faults import FaultValue
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row


class GamepadTwin(PortTwin[PtyPort, GamepadFaults]):
    """Sends all changes of its input, one after the other."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, GamepadRow)
        super().__init__(device.name, PtyPort(device.address), settings.faults)
        self._pad = EmulatedGamepad(settings.faults, seed=around.seed_for(device))
        self._hands = deque([settings.faults])

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Change its input, and return all of it; quick changes are not merged."""
        told = super().fault(name, value)
        self._hands.append(self._faults)
        return told

    def service(self, now: float) -> None:
        """Do all that is due: the cable, records out."""
        if plug(self.port, present=not self._faults.unplug):
            self._pad.plugged()
        self.port.read()
        records = b""
        while self._hands:
            self._pad.hand = self._hands.popleft()
            records += self._pad.poll(now)
        if records:
            self.port.write(records)
