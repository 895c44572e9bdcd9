"""The common part of all emulated devices on ports; your own packages build their twins with this, too."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable
from zlib import crc32

import msgspec
from msgspec import Struct

from lbr.capability import twins
from lbr.capability.context import Device
from lbr.errors import InputError
from lbr.messages.sensing import RangeSensor
from lbr.simulation.cameras.host import CameraHost
from lbr.simulation.faults import Faults, FaultValue, changed
from lbr.simulation.measured import ImuReading, Sensed, ServoDrive, ServoFelt
from lbr.simulation.trace import OutputTrace

S = TypeVar("S", bound=Struct)
F = TypeVar("F", bound=Faults)


class Port(Protocol):
    """The place where a device is plugged in."""

    @property
    def plugged(self) -> bool:
        """Return whether it is plugged in."""

    def fileno(self) -> int:
        """Return the descriptor to select on."""

    def plug(self) -> None:
        """Plug it in."""

    def unplug(self) -> None:
        """Pull it out."""


P = TypeVar("P", bound=Port)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The parts for a twin: seed and time of the world, the trace of the wheels' outputs, its cameras if any.

    `sensors` are the robot's sensors of distance; those in `apart` are named by a device row of their own.
    """

    seed: int
    now: float
    trace: OutputTrace = field(default_factory=lambda: OutputTrace(""))
    cameras: CameraHost | None = None
    mounts: tuple[str, ...] = ()
    sensors: tuple[RangeSensor, ...] = ()
    apart: frozenset[str] = frozenset()

    def seed_for(self, device: Device) -> int:
        """Return the seed of a device's own noise."""
        return self.seed * 1_000_003 + crc32(device.name.encode())


class Twin(Protocol):
    """An emulated device on its port. `fault` is called from another thread than the rest."""

    name: str

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Set a fault and return them all; InputError names the allowed ones."""

    def watched(self) -> int | None:
        """Return the descriptor whose bytes it reads next; None without one."""

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""

    def next_due(self) -> float | None:
        """Return when it next acts by itself."""

    def sense(self, sensed: Sensed) -> None:
        """Set its measurements from the world."""

    def close(self) -> None:
        """Pull it out."""


@runtime_checkable
class Feeling(Protocol):
    """A twin that receives its motion at every step of the world."""

    def feel(self, reading: ImuReading, now: float) -> None:
        """Set the present measurement of an inertial unit."""


@runtime_checkable
class ServoBus(Protocol):
    """A twin whose servos move the joints of a body; called at every step of the world, by the servos' ids.

    A servo's answer is the same object until one of its registers has changed.
    """

    def drives(self, now: float) -> Mapping[int, ServoDrive]:
        """Return each servo's motor state; a servo without power is limp."""

    def feel_servos(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Set the servos' angles in the world, and the voltage of their supply."""


@runtime_checkable
class WheelDrive(Protocol):
    """A twin that turns the wheels of a robot."""

    def wheels(self, now: float) -> tuple[float, float]:
        """Return the power of the left and the right wheel, forward positive."""


@runtime_checkable
class MotorDrive(Protocol):
    """A twin that turns motors of a robot on wheels, whatever their names."""

    def motors(self, now: float) -> Mapping[str, float]:
        """Return the power of each of its motors, by their names in rows of `wheel`, forward positive."""


@runtime_checkable
class PowerSwitch(Protocol):
    """A twin that switches the servos' power."""

    @property
    def motors_on(self) -> bool:
        """Return whether they have power."""


class PortTwin(Generic[P, F]):
    """A twin's port and its faults, which one thread sets and the world's thread applies at its next round."""

    def __init__(self, name: str, port: P, faults: F) -> None:
        self.name = name
        self.port = port
        self._faults = faults

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Set a fault and return them all; InputError names the allowed ones."""
        self._faults = changed(self._faults, name, value)
        return msgspec.structs.asdict(self._faults)

    def watched(self) -> int | None:
        """Return the descriptor whose bytes it reads next; None without one."""
        return self.port.fileno() if self.port.plugged else None

    def next_due(self) -> float | None:
        """Return when it next acts by itself: never, unless a twin overrides this."""

    def sense(self, sensed: Sensed) -> None:
        """Set its measurements from the world: none, unless a twin overrides this."""

    def close(self) -> None:
        """Pull it out."""
        self.port.unplug()


def plug(port: Port, *, present: bool) -> bool:
    """Plug or unplug as needed; return whether it was plugged in."""
    if present == port.plugged:
        return False
    if present:
        port.plug()
    else:
        port.unplug()
    return present


def make(device: Device, around: Surroundings) -> Twin:
    """Return the twin of a device row; raise InputError for its row, and TwinError for its package."""
    declared = twins.find(device.type)
    if declared is None:
        raise InputError(
            f"device '{device.name}': there is no twin for type '{device.type}'; there are {', '.join(twins.names())}. "
            "A package brings one by the twins of its component, once it is installed (pip install -e .)"
        )
    twin: Twin = declared.load()(device, around)
    return twin


def row(device: Device, kind: type[S]) -> S:
    """Return a device's settings; raise InputError with the device's name."""
    try:
        return msgspec.convert(device.settings, kind)
    except msgspec.ValidationError as err:
        raise InputError(f"device '{device.name}' ({device.type}): {err}") from err
