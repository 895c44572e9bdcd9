"""The common part of all emulated devices on ports; a package of your own builds its twins with this, too."""

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
    """Where a device is plugged in."""

    @property
    def plugged(self) -> bool:
        """Return whether it is."""

    def fileno(self) -> int:
        """Return the descriptor to select on."""

    def plug(self) -> None:
        """Plug it in."""

    def unplug(self) -> None:
        """Pull it out."""


P = TypeVar("P", bound=Port)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The parts for building a twin: seed and time of the world, the trace of the wheels' outputs, its cameras if any.

    `sensors` are where the robot has sensors of distance.
    """

    seed: int
    now: float
    trace: OutputTrace = field(default_factory=lambda: OutputTrace(""))
    cameras: CameraHost | None = None
    mounts: tuple[str, ...] = ()
    sensors: tuple[RangeSensor, ...] = ()

    def seed_for(self, device: Device) -> int:
        """Return the seed of a device's own noise."""
        return self.seed * 1_000_003 + crc32(device.name.encode())


class Twin(Protocol):
    """An emulated device on its port. `fault` is asked from another thread than the rest."""

    name: str

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Set a fault and return them all; InputError names the allowed ones."""

    def watched(self) -> int | None:
        """Return the descriptor whose bytes it will take; None: none now."""

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""

    def next_due(self) -> float | None:
        """Return when it next has something to do by itself."""

    def sense(self, sensed: Sensed) -> None:
        """Take in what the world lets it measure."""

    def close(self) -> None:
        """Pull it out."""


@runtime_checkable
class Feeling(Protocol):
    """A twin that receives its motion at every step of the world."""

    def feel(self, reading: ImuReading, now: float) -> None:
        """Take in what an inertial unit measures now."""


@runtime_checkable
class ServoBus(Protocol):
    """A twin whose servos move the joints of a body; asked and told at every step of the world, by the servos' ids.

    A servo's answer is the same object until one of its registers has changed.
    """

    def drives(self, now: float) -> Mapping[int, ServoDrive]:
        """Return what each servo's motor does now; a servo without supply is limp."""

    def feel_servos(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Take in where the world has the servos, and the voltage of their supply."""


@runtime_checkable
class WheelDrive(Protocol):
    """A twin that turns the wheels of a robot."""

    def wheels(self, now: float) -> tuple[float, float]:
        """Return the power of the left and the right wheel, forward positive."""


@runtime_checkable
class MotorDrive(Protocol):
    """A twin that turns motors of a robot on wheels, whatever they are called."""

    def motors(self, now: float) -> Mapping[str, float]:
        """Return the power of each of its motors, by their names in rows of `wheel`, forward positive."""


@runtime_checkable
class PowerSwitch(Protocol):
    """A twin that gives the servos their power, or not."""

    @property
    def motors_on(self) -> bool:
        """Return whether they have power."""


class PortTwin(Generic[P, F]):
    """A twin's port and its faults, which are set by one thread and taken over by the world's at its next round."""

    def __init__(self, name: str, port: P, faults: F) -> None:
        self.name = name
        self.port = port
        self._faults = faults

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Set a fault and return them all; InputError names the allowed ones."""
        self._faults = changed(self._faults, name, value)
        return msgspec.structs.asdict(self._faults)

    def watched(self) -> int | None:
        """Return the descriptor whose bytes it will take; None: none now."""
        return self.port.fileno() if self.port.plugged else None

    def next_due(self) -> float | None:
        """Return when it next has something to do by itself: never, unless a twin overrides this."""

    def sense(self, sensed: Sensed) -> None:
        """Take in what the world lets it measure: nothing, unless a twin overrides this."""

    def close(self) -> None:
        """Pull it out."""
        self.port.unplug()


def plug(port: Port, *, present: bool) -> bool:
    """Plug or unplug as need be; say whether it was plugged in."""
    if present == port.plugged:
        return False
    if present:
        port.plug()
    else:
        port.unplug()
    return present


def make(device: Device, around: Surroundings) -> Twin:
    """Return the twin of a device row; raise InputError for its row, and TwinError for the package that brings it."""
    declared = twins.find(device.type)
    if declared is None:
        raise InputError(
            f"device '{device.name}': there is no twin for type '{device.type}'; there are {', '.join(twins.names())}. A "
            "package brings one by the twins of its component, once it is installed (pip install -e .)"
        )
    twin: Twin = declared.load()(device, around)
    return twin


def row(device: Device, kind: type[S]) -> S:
    """Return what a device's row sets; raise InputError naming the device."""
    try:
        return msgspec.convert(device.settings, kind)
    except msgspec.ValidationError as err:
        raise InputError(f"device '{device.name}' ({device.type}): {err}") from err
