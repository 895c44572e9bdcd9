"""The number of requests under way at once, of one client and of all."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

MOST_OF_ONE = 16
MOST = 48
"""Fewer than the connections, so that there is always one that waits and can be cut for another."""


class Turns:
    """Counts the requests and viewers of each client."""

    def __init__(self, most_of_one: int = MOST_OF_ONE, most: int = MOST) -> None:
        self.most_of_one = most_of_one
        self.most = most
        self._taken: Counter[str] = Counter()

    def why_not(self, client: str) -> str:
        """Return why a client has no turn now; empty if it has."""
        if self._taken[client] >= self.most_of_one:
            return f"{self.most_of_one} of one asker"
        return f"{self.most}" if self._taken.total() >= self.most else ""

    @contextmanager
    def turn(self, client: str) -> Iterator[None]:
        """Take a turn during a `with`."""
        self._taken[client] += 1
        try:
            yield
        finally:
            self._taken[client] -= 1
            if not self._taken[client]:
                del self._taken[client]
