"""Tells whether messages still pass through the door and its threads go round. Pure; it counts rounds, not seconds.

A machine that has no time for this process has none for what it hears either, so nothing is concluded from its silence.
"""

from msgspec import Struct

DOUBTED_AFTER = 3
"""The rate of the robot's statuses outside for all that came by another way than the door: one a second."""
BROKEN_AFTER = 3


class Passage(Struct):
    """A flood may lose statuses at the door, so a doubt is put as a question; several without an answer are a fault."""

    missed: int = 0
    unanswered: int = 0

    @property
    def doubtful(self) -> bool:
        """Return whether it is time to ask through the door."""
        return self.missed >= DOUBTED_AFTER

    @property
    def broken(self) -> bool:
        """Return whether nothing passes any more."""
        return self.unanswered >= BROKEN_AFTER

    def count_statuses(self, *, outside: bool, inside: bool) -> None:
        """Count a round: whether a status came from the robot, and whether one came through the door."""
        if inside:
            self.missed = self.unanswered = 0
        elif outside:
            self.missed += 1

    def asked(self, *, answered: bool) -> None:
        """Take in what became of a question."""
        if answered:
            self.missed = self.unanswered = 0
        else:
            self.unanswered += 1


class Standstill:
    """Counts for each thread how often in a row it was seen to have done nothing."""

    def __init__(self) -> None:
        self._seen: dict[str, tuple[int, int]] = {}

    def see(self, name: str, turns: int) -> int:
        """Take in how many turns a thread has made; return how often in a row that was the same."""
        before, still = self._seen.get(name, (-1, 0))
        still = still + 1 if turns == before else 0
        self._seen[name] = turns, still
        return still
