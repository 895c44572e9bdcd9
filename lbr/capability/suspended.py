"""Detects that this computer was suspended: its monotonic clock stops meanwhile, so no deadline passes."""

import time

LEAST_S = 0.5
"""A shorter suspension ends no motion."""


class Suspended:
    """Compares the clock that goes on while the computer sleeps with the one that stops."""

    def __init__(self) -> None:
        self._apart_s = _apart_s()[1]

    def for_s(self) -> float:
        """Return how long the computer was suspended since the last call; 0 if it was not."""
        least_s, most_s = _apart_s()
        slept_s = least_s - self._apart_s
        if slept_s > LEAST_S:
            self._apart_s = most_s
            return slept_s
        self._apart_s = min(self._apart_s, most_s)
        return 0.0


def _apart_s() -> tuple[float, float]:
    """Return the least and the greatest difference of the clocks: the process may pause between their readings."""
    before = time.monotonic()
    boot = time.clock_gettime(time.CLOCK_BOOTTIME)
    return boot - time.monotonic(), boot - before
