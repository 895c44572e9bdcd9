"""The number of requests under way at once, of one asker and of all together."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

MOST_OF_ONE = 16
MOST = 48
"""Fewer than the connections there may be, so that there is always one that waits and can be cut for another."""


class Turns:
    """Counts who is being answered, or watches."""

    def __init__(self, most_of_one: int = MOST_OF_ONE, most: int = MOST) -> None:
        self.most_of_one = most_of_one
        self.most = most
        self._taken: Counter[str] = Counter()

    def why_not(self, client: str) -> str:
        """Return why there is no turn for a client now; empty if there is."""
        if self._taken[client] >= self.most_of_one:
            return f"{self.most_of_one} of one asker"
        return f"{self.most}" if self._taken.total() >= self.most else ""

    @contextmanager
    def turn(self, client: str) -> Iterator[None]:
        """Have a turn for the time of a `with`."""
        self._taken[client] += 1
        try:
            yield
        finally:
            self._taken[client] -= 1
            if not self._taken[client]:
                del self._taken[client]
