"""The emulated LD06 lidar on its port."""

from collections.abc import Sequence
from math import tau

from lbr.capability.context import Device
from lbr.messages.sensing import RangeSensor
from lbr.simulation.devices.ld06 import Ld06Faults, Ld06Row
from lbr.simulation.devices.ld06.device import Ld06
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin


class Ld06Twin(LineTwin[Ld06Faults]):
    """Sends the distances around the place in its row of `range_sensor`; without that row, none."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, Ld06Row)
        self._sensor = next((sensor for sensor in around.sensors if sensor.name == settings.sensor), None)
        self._lidar = Ld06(faults=settings.faults, seed=around.seed_for(device), powered_at=around.now)
        super().__init__(device, settings.faults, self._lidar)

    def cable(self, now: float) -> None:
        """Begin anew with each cable, which brings its power."""
        if self.port.plugged:
            self._lidar.power_cycle(now)

    def sense(self, sensed: Sensed) -> None:
        """Set the surroundings from the world."""
        sensor = self._sensor
        if sensor is not None and sensor.name in sensed.scans_m:
            faced = sensed.scans_m[sensor.name]
            self._lidar.face = lambda angle_rad: _along(faced, sensor, angle_rad)


def _along(faced: Sequence[float | None], sensor: RangeSensor, angle_rad: float) -> float | None:
    """Return the distance along an angle, by the nearest ray; None where there is no ray."""
    number = int(((angle_rad - sensor.first_rad + sensor.step_rad / 2) % tau) / sensor.step_rad)
    return faced[number] if number < len(faced) else None
