"""A lead-acid battery that sags under load and empties with use."""

from lbr.simulation.settings import Battery

_EMPTY_DROP_V = 2.2
"""How far the voltage at rest falls from full to empty."""

_SETTLE_S = 0.14
"""Time constant of a step in load: surface charge and filters."""


class BatteryState:
    """Volts and charge of one battery."""

    def __init__(self, settings: Battery) -> None:
        self._settings = settings
        self.charge = settings.charge
        self.amps_a = settings.idle_a
        self.voltage_v = self._target_v()

    def draw(self, motor_amps_a: float, dt_s: float) -> None:
        """Take the motors' current, and what idles, for a while."""
        self.amps_a = self._settings.idle_a + max(0.0, motor_amps_a)
        self.charge = max(0.0, self.charge - self.amps_a * dt_s / 3600 / self._settings.capacity_ah)
        self.voltage_v += (self._target_v() - self.voltage_v) * min(1.0, dt_s / _SETTLE_S)

    def _target_v(self) -> float:
        settings = self._settings
        rest_v = settings.open_circuit_v - (1.0 - self.charge) * _EMPTY_DROP_V
        return max(0.0, rest_v - self.amps_a * settings.internal_ohm)
