"""A lead-acid battery that sags under load, empties with use and fills on a dock."""

from bisect import bisect_right

from lbr.simulation.settings import Battery

_FULL_V = 12.7
_AT_REST = (
    (0.0, 10.5), (0.1, 11.3), (0.2, 11.5), (0.3, 11.7), (0.4, 11.9), (0.5, 12.0),
    (0.6, 12.2), (0.7, 12.4), (0.8, 12.5), (0.9, 12.6), (1.0, _FULL_V),
)  # fmt: skip
"""Charge and volts at rest of a 12 V AGM."""

_SETTLE_S = 0.14
"""Time constant of a step in load: surface charge and filters."""

_TAPER = 0.05
"""The last part of the charge, in which the charger's current falls."""


class BatteryState:
    """Volts and charge of one battery; `amps_a` leave it, `charging_a` come from the dock."""

    def __init__(self, settings: Battery) -> None:
        self._settings = settings
        self.charge = settings.charge
        self.amps_a = settings.idle_a
        self.charging_a = 0.0
        self._surface_v = 0.0
        self.voltage_v = self._target_v()

    def draw(self, motor_amps_a: float, dt_s: float, charger_a: float = 0.0) -> None:
        """Draw the current of the motors and of the idle electronics; a charger gives up to `charger_a` (0: no
        charger)."""
        settings = self._settings
        load_a = settings.idle_a + max(0.0, motor_amps_a)
        taper_a = (1.0 - self.charge) / _TAPER * charger_a
        self.charging_a = min(charger_a, load_a + taper_a)
        self.amps_a = load_a - self.charging_a
        self.charge = max(0.0, min(1.0, self.charge - self.amps_a * dt_s / 3600 / settings.capacity_ah))
        surface_v = max(0.0, settings.charged_v - self._rest_v()) if charger_a > 0.0 else 0.0
        self._surface_v += (surface_v - self._surface_v) * min(1.0, dt_s / settings.charging_s)
        self.voltage_v += (self._target_v() - self.voltage_v) * min(1.0, dt_s / _SETTLE_S)

    def _target_v(self) -> float:
        settings = self._settings
        highest_v = max(settings.charged_v, settings.open_circuit_v)
        return max(0.0, min(highest_v, self._rest_v() + self._surface_v - self.amps_a * settings.internal_ohm))

    def _rest_v(self) -> float:
        """Return the voltage without load and without a charger, between the points of the table."""
        at = min(len(_AT_REST) - 1, max(1, bisect_right(_AT_REST, (self.charge, 0.0))))
        (low, low_v), (high, high_v) = _AT_REST[at - 1 : at + 1]
        return low_v + (high_v - low_v) * (self.charge - low) / (high - low) + self._settings.open_circuit_v - _FULL_V
