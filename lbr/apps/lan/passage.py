"""Checks that messages still pass through the door, and that its threads run. Pure; it counts rounds, not seconds.

A machine too busy for this process is too busy for its messages as well, so silence on both sides proves nothing.
"""

from msgspec import Struct

DOUBTED_AFTER = 3
"""The statuses, one a second, that came from the robot and not through the door before a doubt."""
BROKEN_AFTER = 3


class Passage(Struct):
    """A flood may lose statuses at the door, so a doubt leads to a query; several unanswered queries are a fault."""

    missed: int = 0
    unanswered: int = 0

    @property
    def doubtful(self) -> bool:
        """Return whether to query through the door."""
        return self.missed >= DOUBTED_AFTER

    @property
    def broken(self) -> bool:
        """Return whether nothing passes through the door."""
        return self.unanswered >= BROKEN_AFTER

    def count_statuses(self, *, outside: bool, inside: bool) -> None:
        """Count a round: whether a status came from the robot, and whether one came through the door."""
        if inside:
            self.missed = self.unanswered = 0
        elif outside:
            self.missed += 1

    def asked(self, *, answered: bool) -> None:
        """Count the result of a query."""
        if answered:
            self.missed = self.unanswered = 0
        else:
            self.unanswered += 1


class Standstill:
    """Counts, for each thread, the checks in a row without progress."""

    def __init__(self) -> None:
        self._seen: dict[str, tuple[int, int]] = {}

    def see(self, name: str, turns: int) -> int:
        """Note a thread's count of rounds; return how many checks in a row it was the same."""
        before, still = self._seen.get(name, (-1, 0))
        still = still + 1 if turns == before else 0
        self._seen[name] = turns, still
        return still
