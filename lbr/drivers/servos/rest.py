"""The judge of servos at rest, which are read seldom: they have not moved, and got no new order.

Fed by the bus's thread with each measured place, and stirred by any thread with each order and each trouble.
"""

from collections.abc import Callable

STILL_S = 0.5
"""The time without motion, order and trouble that makes a rest: a servo begins to move 0.05 s after its order."""
FULL_S = 0.5
"""At rest all of each servo is read in this time, its fault and its torque too. Chosen, not measured."""
BELIEVED_S = 0.3
"""A setpoint that wants nothing new of servos at rest holds for this long: three at a mover's own pace at rest."""


class Rest:
    """`lasts` while all servos stay within a band of angle and load around where they were; `woken` is called at its
    end."""

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
        """Take in a measured place; noise within the bands is no motion."""
        like = self._like.get(servo)
        if like is None or abs(position_rad - like[0]) > self._band_rad or abs(load - like[1]) > self._band_load:
            self._like[servo] = position_rad, load
            self.stir()

    def stir(self) -> None:
        """End the rest, or put it off."""
        lasted, self._since = self.lasts, self._clock()
        if lasted:
            self._woken()
