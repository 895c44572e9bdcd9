"""The rest of a body that stands or lies: its physics would only shake it, by less than a servo's step."""

import numpy as np

from lbr.simulation.humanoid.servos import Floats

STILL_S = 1.0
"""So long without motion is a rest. A body that tips over moves a hundred times further meanwhile."""
STILL_M, STILL_RAD = 1e-3, 3e-3
"""A smaller change is no motion; servos count in steps of 5 mrad and more."""
SAG_V = 0.1
"""After a greater change of the supply, the motors push with other force."""


class Stillness:
    """Detects rest: `look` at a body at intervals; `end` its rest with each push."""

    def __init__(self, places: Floats) -> None:
        count = len(places) - 7
        self._most = np.repeat((STILL_M, STILL_RAD / 2, STILL_RAD), (3, 4, count))  # a quaternion has half the angle
        self._low: Floats | None = None
        self._high = self._most
        self._since_s = 0.0
        self._rested_v: float | None = None

    def rests(self, supply_v: float) -> bool:
        """Return whether it has come to rest, and its supply has not changed since."""
        return self._rested_v is not None and abs(supply_v - self._rested_v) < SAG_V

    def end(self) -> None:
        """Begin anew."""
        self._low = self._rested_v = None

    def look(self, places: Floats, time_s: float, supply_v: float, *, about_to: bool) -> bool:
        """Note its place; return whether a rest begins now. `about_to`: something is about to move it."""
        self._rested_v = None
        if self._low is not None and not about_to:
            self._low, self._high = np.minimum(self._low, places), np.maximum(self._high, places)
        if self._low is None or about_to or (self._high - self._low > self._most).any():
            self._low, self._high, self._since_s = np.array(places), np.array(places), time_s
            return False
        if time_s - self._since_s < STILL_S:
            return False
        self._low, self._rested_v = None, supply_v
        return True
