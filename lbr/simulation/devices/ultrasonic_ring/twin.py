"""The emulated ring of ultrasonic sensors on its port."""

from typing import Any

from lbr.capability.context import Device
from lbr.errors import InputError
from lbr.simulation.devices.ultrasonic_ring import UltrasonicFaults, UltrasonicRow
from lbr.simulation.devices.ultrasonic_ring.device import ORDER, UltrasonicBoard
from lbr.simulation.faults import FaultValue
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin


class UltrasonicTwin(LineTwin[UltrasonicFaults]):
    """Sends the distances before its sensors."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, UltrasonicRow)
        apart = around.apart.union(ORDER)
        self._board = UltrasonicBoard(
            settings.board,
            faults=settings.faults,
            seed=around.seed_for(device),
            powered_at=around.now,
            more=tuple(one.name for one in around.sensors if one.rays == 1 and one.level and one.name not in apart),
        )
        super().__init__(device, settings.faults, self._board)

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Set a fault and return them all; raise InputError with the permitted ones, also for a missing sensor."""
        before, sensors = self._faults, self._board.sensors
        faults = super().fault(name, value)
        struck = (*self._faults.missing, *self._faults.over_range, *self._faults.error)
        if strange := [sensor for sensor in struck if sensor not in sensors]:
            self._faults = before
            raise InputError(f"fault '{name}': there is no sensor '{strange[0]}'; there is {', '.join(sensors)}")
        return faults

    def cable(self, now: float) -> None:
        """Begin anew with each cable, which brings its power."""
        if self.port.plugged:
            self._board.power_cycle(now)

    def hear(self, data: bytes, now: float) -> bytes:
        """Receive bytes; return the bytes that have crossed the line back."""
        return self._board.feed(data, now)

    def sense(self, sensed: Sensed) -> None:
        """Set the distances from the world."""
        self._board.distances_m = sensed.ranges_m
        self._board.not_there = frozenset(self._board.sensors) - sensed.ranges_m.keys()
