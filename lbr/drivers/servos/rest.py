"""Detection of servos at rest, which are read seldom: they have not moved, and got no new order.

The bus's thread adds each measured position; any thread ends the rest with each order and each problem.
"""

from collections.abc import Callable

STILL_S = 0.5
"""The time without motion, order and problem after which servos rest; a servo begins to move 0.05 s after its order."""
FULL_S = 0.5
"""The time in which every servo at rest is read in full, with faults and torque. Chosen, not measured."""
BELIEVED_S = 0.3
"""The life of a setpoint that changes nothing for servos at rest: three periods of a sender at its own rate at rest."""


class Rest:
    """Tracks whether all servos stay within a band of angle and load; `woken` is called when the rest ends."""

    def __init__(
        self,
        clock: Callable[[], float],
        band_rad: float = 0.0,
        band_load: float = 0.0,
        woken: Callable[[], None] = lambda: None,
    ) -> None:
        self._clock = clock
        self._band_rad = band_rad
        self._band_load = band_load
        self._woken = woken
        self._since = clock()
        self._like: dict[int, tuple[float, float]] = {}

    @property
    def lasts(self) -> bool:
        """Return whether the servos rest."""
        return self._clock() - self._since >= STILL_S

    def look(self, servo: int, position_rad: float, load: float) -> None:
        """Add a measured position; noise within the bands is no motion."""
        like = self._like.get(servo)
        if like is None or abs(position_rad - like[0]) > self._band_rad or abs(load - like[1]) > self._band_load:
            self._like[servo] = position_rad, load
            self.stir()

    def stir(self) -> None:
        """End the rest, or restart its time."""
        lasted, self._since = self.lasts, self._clock()
        if lasted:
            self._woken()
