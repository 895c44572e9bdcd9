"""A service of the executive: a part that the main loop gives its turn to, and that is closed at the end."""

from math import inf


class Service:
    """Does nothing of its own accord until it says otherwise."""

    def step(self, _now: float) -> float:
        """Do what is due now, by the monotonic clock; return when it is to be called again."""
        return inf

    def close(self) -> None:
        """Take no more, and free what it holds."""
