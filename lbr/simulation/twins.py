"""Emulated devices in the world: each a pure device on a port, wired to what the engine moves and senses."""

from typing import Any, Protocol, TypeVar
from zlib import crc32

import msgspec
from msgspec import Struct

from lbr.capability.context import Device
from lbr.errors import InputError
from lbr.simulation.faults import FaultValue, changed
from lbr.simulation.measured import Measured, Sensed
from lbr.simulation.port import PtyPort
from lbr.simulation.roboteq import RoboteqDevice
from lbr.simulation.rows import RoboteqRow, UltrasonicRow
from lbr.simulation.trace import OutputTrace
from lbr.simulation.ultrasonic import UltrasonicBoard

Pair = tuple[float, float]
S = TypeVar("S", bound=Struct)
N = TypeVar("N", int, float)

_INTERNAL_DROP_V = 0.4
_AMBIENT_C = 28.0
_WARMING_C_PER_A = 0.8


class Twin(Protocol):
    """An emulated device on its port."""

    name: str
    port: PtyPort

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Set a fault and return them all; raise InputError saying what is allowed."""

    def reads(self) -> bool:
        """Say whether it takes bytes from its port now."""

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""

    def next_due(self) -> float | None:
        """Return when it next has something to do by itself."""

    def sense(self, sensed: Sensed) -> None:
        """Take in what the world lets it measure."""


class RoboteqTwin:
    """The emulated motor controller on its port."""

    def __init__(self, device: Device, *, seed: int, trace: OutputTrace) -> None:
        self.name = device.name
        self.port = PtyPort(device.address)
        self._row = _row(device, RoboteqRow)
        self._trace = trace
        self._device = RoboteqDevice(faults=self._row.faults, seed=_seed(seed, device.name), heard=self._heard)
        self._left = self._row.left_channel - 1
        self._faults = self._row.faults  # set by another thread, taken over in `service`

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Set a fault and return them all; raise InputError saying what is allowed."""
        self._faults = changed(self._faults, name, value)
        return msgspec.structs.asdict(self._faults)

    def reads(self) -> bool:
        """Say whether it takes bytes from its port now."""
        return self.port.plugged and not self._device.faults.stop_reading

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out, the outputs."""
        if self._device.faults is not self._faults:
            self._device.faults = self._faults
        present = self._device.present(now)
        if self.port.plugged and not present and self._device.faults.unplug:
            self._trace.outputs(now, self.wheels(now), "unplug", always=True)
        _plug(self.port, present=present)
        heard = self.port.read() if self.reads() else b""
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
        left, right = outputs[self._left], outputs[1 - self._left]
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
        return (left, right) if self._left == 0 else (right, left)

    def _heard(self, line: str, now: float) -> None:
        self._trace.line(now, line)
        self._trace.outputs(now, self.wheels(now), self._device.cause(now))


class UltrasonicTwin:
    """An emulated ultrasonic board on its port."""

    def __init__(self, device: Device, *, seed: int, now: float) -> None:
        self.name = device.name
        self.port = PtyPort(device.address)
        row = _row(device, UltrasonicRow)
        self._board = UltrasonicBoard(row.board, faults=row.faults, seed=_seed(seed, device.name), powered_at=now)
        self._faults = row.faults  # set by another thread, taken over in `service`

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Set a fault and return them all; raise InputError saying what is allowed."""
        self._faults = changed(self._faults, name, value)
        return msgspec.structs.asdict(self._faults)

    def reads(self) -> bool:
        """Say whether it takes bytes from its port now."""
        return self.port.plugged

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""
        self._board.faults = self._faults
        if _plug(self.port, present=not self._board.faults.unplug):
            self._board.power_cycle(now)
        heard = self.port.read()
        said = self._board.feed(heard, now) if heard else self._board.poll(now)
        if said:
            self.port.write(said)

    def next_due(self) -> float | None:
        """Return when it next has something to do by itself."""
        return self._board.next_due()

    def sense(self, sensed: Sensed) -> None:
        """Face what the world puts before the sensors."""
        self._board.distances_m = sensed.ranges_m


def _plug(port: PtyPort, *, present: bool) -> bool:
    """Plug or unplug as need be; say whether it was plugged in."""
    if present == port.plugged:
        return False
    if present:
        port.plug()
    else:
        port.unplug()
    return present


def _row(device: Device, kind: type[S]) -> S:
    try:
        return msgspec.convert(device.settings, kind)
    except msgspec.ValidationError as err:
        raise InputError(f"device '{device.name}' ({device.type}): {err}") from err


def _seed(seed: int, name: str) -> int:
    return seed * 1_000_003 + crc32(name.encode())
