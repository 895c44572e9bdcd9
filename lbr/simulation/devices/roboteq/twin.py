"""The emulated motor controller on its port."""

from typing import TypeVar

from lbr.capability.context import Device
from lbr.simulation.devices.roboteq import RoboteqFaults, RoboteqRow
from lbr.simulation.devices.roboteq.device import Measured, RoboteqDevice
from lbr.simulation.measured import Sensed
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row

Pair = tuple[float, float]
N = TypeVar("N", int, float)

_INTERNAL_DROP_V = 0.4
_AMBIENT_C = 28.0
_WARMING_C_PER_A = 0.8


class RoboteqTwin(PortTwin[PtyPort, RoboteqFaults]):
    """Moves the wheels, and measures motors and battery."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        self._row = row(device, RoboteqRow)
        super().__init__(device.name, PtyPort(device.address), self._row.faults)
        self._trace = around.trace
        self._device = RoboteqDevice(faults=self._row.faults, seed=around.seed_for(device), on_command=self._trace_line)
        self._left_index = self._row.left_channel - 1

    def watched(self) -> int | None:
        """Return the descriptor whose bytes it will take; None: none now."""
        return None if self._device.faults.stop_reading else super().watched()

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out, the outputs."""
        if self._device.faults is not self._faults:
            self._device.faults = self._faults
        present = self._device.present(now)
        if self.port.plugged and not present and self._device.faults.unplug:
            self._trace.outputs(now, self.wheels(now), "unplug", always=True)
        plug(self.port, present=present)
        heard = b"" if self._device.faults.stop_reading else self.port.read()
        answer = self._device.feed(heard, now) if heard else self._device.poll(now)
        if answer:
            self.port.write(answer)
        self._trace.outputs(now, self.wheels(now), self._device.cause(now))

    def next_due(self) -> float | None:
        """Return when it next has something to do by itself."""
        return self._device.next_due()

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
