"""The controller's last measurements, for as long as they can be believed."""

from collections.abc import Callable
from typing import TypeVar

from lbr.drivers.roboteq import RoboteqSettings, Wheel
from lbr.drivers.roboteq.protocol import Value
from lbr.drivers.roboteq.readings import Amps, Channels, Flags, Reading, Setting, Temperatures, Volts, decode
from lbr.drivers.wheels.contract import Measured

BELIEVED_S, SLOW_BELIEVED_S = 1.0, 2.5
"""Voltage, temperature and settings are asked for once a second at rest."""
R = TypeVar("R", bound=Reading)


class Telemetry:
    """The newest answer to each query; one that is too old counts as not measured."""

    def __init__(self, settings: RoboteqSettings, clock: Callable[[], float]) -> None:
        self._left = settings.left
        self._right = settings.right
        self._clock = clock
        self._newest: dict[str, tuple[Reading, float]] = {}

    def take(self, value: Value) -> None:
        """Remember an answer."""
        self._newest[value.name] = (decode(value), self._clock())

    def forget_faults(self) -> None:
        """Wait for fault bits again."""
        self._newest.pop("FF", None)

    @property
    def faults(self) -> tuple[str, ...] | None:
        """Names of the fault bits set; None: not known."""
        flags = self._believed("FF", Flags)
        return flags.names if flags else None

    def faults_after(self, when: float) -> tuple[str, ...] | None:
        """The fault bits if they were read after `when`; None otherwise."""
        taken = self._newest.get("FF")
        return self.faults if taken and taken[1] > when else None

    @property
    def watchdog_ms(self) -> int | None:
        """The controller's watchdog as it was last read back."""
        setting = self._believed("RWD", Setting, SLOW_BELIEVED_S)
        return setting.value if setting else None

    def measured(self) -> Measured:
        """Return everything as fields of MotorsState, currents and counts forward positive."""
        volts = self._believed("V", Volts, SLOW_BELIEVED_S) or Volts(None, None, None)
        amps = self._believed("A", Amps) or Amps(())
        counts = self._believed("C", Channels) or Channels(())
        temperatures = self._believed("T", Temperatures, SLOW_BELIEVED_S) or Temperatures(())
        return Measured(
            voltage_v=volts.battery_v,
            internal_v=volts.internal_v,
            output_v=volts.output_v,
            amps_left_a=_forward(amps.amps_a, self._left),
            amps_right_a=_forward(amps.amps_a, self._right),
            counts_left=_forward(counts.values, self._left),
            counts_right=_forward(counts.values, self._right),
            temperature_c=temperatures.hottest_c,
            faults=self.faults or (),
        )

    def _believed(self, name: str, kind: type[R], for_s: float = BELIEVED_S) -> R | None:
        reading, taken = self._newest.get(name, (None, 0.0))
        if isinstance(reading, kind) and self._clock() - taken < for_s:
            return reading
        return None


V = TypeVar("V", int, float)


def _forward(values: tuple[V | None, ...], wheel: Wheel) -> V | None:
    """Return a wheel's value, forward positive: a mirrored motor counts and draws the other way."""
    value = values[wheel.channel - 1] if wheel.channel <= len(values) else None
    return None if value is None else value * wheel.direction
