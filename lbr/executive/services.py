"""A service of the executive: the main loop steps it, and closes it at the end."""

from math import inf


class Service:
    """Does nothing. A service overrides what it needs."""

    def step(self, _now: float) -> float:
        """Do what is due now, by the monotonic clock; return when to call again."""
        return inf

    def close(self) -> None:
        """Accept no more work, and free all resources."""
