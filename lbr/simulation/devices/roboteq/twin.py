"""The emulated motor controller on its port."""

from typing import TypeVar

from lbr.capability.context import Device
from lbr.simulation.devices.roboteq import RoboteqFaults, RoboteqRow
from lbr.simulation.devices.roboteq.device import Measured, RoboteqDevice
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin

Pair = tuple[float, float]
N = TypeVar("N", int, float)

_INTERNAL_DROP_V = 0.4
_AMBIENT_C = 28.0
_WARMING_C_PER_A = 0.8


class RoboteqTwin(LineTwin[RoboteqFaults]):
    """Moves the wheels, and measures motors and battery."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        self._row = row(device, RoboteqRow)
        self._trace = around.trace
        self._device = RoboteqDevice(faults=self._row.faults, seed=around.seed_for(device), on_command=self._trace_line)
        self._left_index = self._row.left_channel - 1
        super().__init__(device, self._row.faults, self._device)

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out, the outputs."""
        super().service(now)
        self._trace.outputs(now, self.wheels(now), self._device.cause(now))

    def present(self, now: float) -> bool:
        """Return whether the host sees the port."""
        return self._device.present(now)

    def cable(self, now: float) -> None:
        """Trace the outputs at the moment when the cable was pulled out."""
        if self._faults.unplug:
            self._trace.outputs(now, self.wheels(now), "unplug", always=True)

    def hear(self, data: bytes, now: float) -> bytes:
        """Receive bytes; return the bytes that have crossed the line back."""
        return self._device.feed(data, now)

    def wheels(self, now: float) -> Pair:
        """Return the power of the left and the right wheel, forward positive."""
        outputs = self._device.outputs(now)
        left, right = outputs[self._left_index], outputs[1 - self._left_index]
        return (left * self._row.left_direction + 0.0, right * self._row.right_direction + 0.0)

    def sense(self, sensed: Sensed) -> None:
        """Measure the motors and the battery."""
        self._device.measured = Measured(
            battery_v=sensed.battery_v,
            internal_v=max(0.0, sensed.battery_v - _INTERNAL_DROP_V),
            amps_a=self._channels(sensed.amps_a),
            battery_amps_a=self._channels(sensed.battery_amps_a),
            counts=self._channels(sensed.counts),
            speeds_rpm=self._channels(sensed.speeds_rpm),
            temperature_c=_AMBIENT_C + _WARMING_C_PER_A * sum(abs(amps) for amps in sensed.amps_a),
        )

    def _channels(self, wheels: tuple[N, N]) -> tuple[N, N]:
        left, right = wheels[0] * self._row.left_direction, wheels[1] * self._row.right_direction
        return (left, right) if self._left_index == 0 else (right, left)

    def _trace_line(self, line: str, now: float) -> None:
        self._trace.line(now, line)
        self._trace.outputs(now, self.wheels(now), self._device.cause(now))
