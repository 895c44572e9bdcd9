"""The controller's last measurements, as long as they are fresh enough."""

from collections.abc import Callable
from typing import TypeVar

from lbr.drivers.echoed_lines import Value
from lbr.drivers.roboteq import RoboteqSettings, Wheel, readings
from lbr.drivers.wheels.contract import Measured

BELIEVED_S, SLOW_BELIEVED_S = 1.0, 2.5
"""The greatest ages. Voltage, temperature and settings are queried once a second at rest."""


class Telemetry:
    """The newest answer to each query; an answer that is too old becomes empty, which means not measured."""

    def __init__(self, settings: RoboteqSettings, clock: Callable[[], float]) -> None:
        self._left = settings.left
        self._right = settings.right
        self._clock = clock
        self._newest: dict[str, tuple[str, float]] = {}

    def take(self, value: Value) -> None:
        """Store an answer."""
        self._newest[value.name] = (value.text, self._clock())

    def forget_faults(self) -> None:
        """Discard the fault bits until they are read again."""
        self._newest.pop("FF", None)

    @property
    def faults(self) -> tuple[str, ...] | None:
        """Names of the set fault bits; None if unknown."""
        return readings.faults(self._believed("FF"))

    def faults_after(self, when: float) -> tuple[str, ...] | None:
        """The fault bits if they were read after `when`; None otherwise."""
        answer = self._newest.get("FF")
        return self.faults if answer and answer[1] > when else None

    @property
    def watchdog_ms(self) -> int | None:
        """The controller's watchdog as it was last read back."""
        return readings.setting(self._believed("RWD", SLOW_BELIEVED_S))

    def measured(self) -> Measured:
        """Return everything as fields of MotorsState, currents and counts forward positive."""
        internal_v, battery_v, output_v = readings.volts(self._believed("V", SLOW_BELIEVED_S))
        amps_a, counts = readings.amps(self._believed("A")), readings.counts(self._believed("C"))
        return Measured(
            voltage_v=battery_v,
            internal_v=internal_v,
            output_v=output_v,
            amps_left_a=_forward(amps_a, self._left),
            amps_right_a=_forward(amps_a, self._right),
            counts_left=_forward(counts, self._left),
            counts_right=_forward(counts, self._right),
            temperature_c=readings.hottest_c(self._believed("T", SLOW_BELIEVED_S)),
            faults=self.faults or (),
        )

    def _believed(self, name: str, for_s: float = BELIEVED_S) -> str:
        text, answered_at = self._newest.get(name, ("", 0.0))
        return text if self._clock() - answered_at < for_s else ""


V = TypeVar("V", int, float)


def _forward(values: tuple[V | None, ...], wheel: Wheel) -> V | None:
    """Return a wheel's value, forward positive: a mirrored motor counts and draws the other way."""
    value = values[wheel.channel - 1] if wheel.channel <= len(values) else None
    return None if value is None else value * wheel.direction
