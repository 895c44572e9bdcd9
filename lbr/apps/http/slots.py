"""Decides which connections to hold, and which to cut when they are too many or too slow. Pure.

A new connection is always admitted: its request is known only once its head is read, and it may be a stop. A connection
that requests nothing yet, or has waited longest, makes room for it.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Phase = Literal["greeting", "idle", "head", "asking", "stopping", "watching", "leaving"]
MOST = 128
"""The most connections, viewers excluded; each takes some 20 kB, with an incomplete head 16 more."""
LIMIT_S: dict[Phase, float] = {
    "greeting": 2.0,  # TLS; 0.3 s over a slow radio
    "head": 2.0,
    "idle": 10.0,
    "asking": 40.0,  # a body may take 10 s and an answer 20, and then the client has to read it
    "stopping": 40.0,
    "leaving": 2.0,
}
_WAITS: frozenset[Phase] = frozenset({"greeting", "idle", "head"})
_CUT_FIRST: tuple[frozenset[Phase], ...] = (frozenset({"leaving"}), _WAITS, frozenset({"asking"}))


@dataclass(eq=False, slots=True)
class Slot:
    """A connection of `peer`: its phase and since when, how to abort it, and whether it is closing.

    A `watching` connection goes on by itself, and is bounded elsewhere.
    """

    peer: str
    cut: Callable[[], None]
    closes: Callable[[], bool]
    since: float
    phase: Phase = "idle"


class Slots:
    """The connections of one server, oldest first."""

    def __init__(self, most: int = MOST) -> None:
        self._most = most
        self._held: dict[Slot, None] = {}

    def __len__(self) -> int:
        return len(self._held)

    def enter(self, slot: Slot) -> Slot | None:
        """Add a connection; return the one to cut for it, or None."""
        bounded = [one for one in self._held if one.phase != "watching"]
        self._held[slot] = None
        if len(bounded) < self._most:
            return None
        victim = _victim(bounded)
        self.leave(victim)
        return victim

    def leave(self, slot: Slot) -> None:
        """Remove a connection."""
        self._held.pop(slot, None)

    def to(self, slot: Slot, phase: Phase, now: float) -> None:
        """Note a connection's phase."""
        if slot.phase != phase:
            slot.phase, slot.since = phase, now

    def overdue(self, now: float) -> list[Slot]:
        """Remove and return the connections that take too long in their phase."""
        for slot in self._held:
            if slot.closes():
                self.to(slot, "leaving", now)
        late = [slot for slot in self._held if now - slot.since > LIMIT_S.get(slot.phase, float("inf"))]
        for slot in late:
            self.leave(slot)
        return late


def _victim(held: list[Slot]) -> Slot:
    """Return the oldest of the least important connections, of the peer with most of these; stops are cut last."""
    for phases in _CUT_FIRST:
        candidates = [slot for slot in held if slot.phase in phases]
        if candidates:
            counts = Counter(slot.peer for slot in candidates)
            return min(candidates, key=lambda slot: (-counts[slot.peer], slot.since))
    return min(held, key=lambda slot: slot.since)
