"""A service of the executive: a part that the main loop steps, and closes at the end."""

from math import inf


class Service:
    """Does nothing. A service overrides what it needs."""

    def step(self, _now: float) -> float:
        """Do what is due now, by the monotonic clock; return when to call again."""
        return inf

    def close(self) -> None:
        """Accept no more, and free what it holds."""
