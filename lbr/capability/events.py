"""Limits how many events of a kind are told: a burst, then a steady trickle; what was left out is counted, never lost
silently."""

BURST = 20.0
PER_S = 2.0
MOST_KINDS = 256


class Throttle:
    """A bucket of tokens for each kind of event. Pure: the caller says what time it is."""

    def __init__(self) -> None:
        self._buckets: dict[str, tuple[float, float]] = {}
        self._missed: dict[str, int] = {}

    def take(self, kind: str, now: float) -> bool:
        """Return whether an event of this kind may be told now; if not, it is counted."""
        room, since = self._buckets.get(kind, (BURST, now))
        room = min(BURST, room + (now - since) * PER_S)
        if len(self._buckets) > MOST_KINDS:
            self._buckets.clear()
        if room >= 1.0:
            self._buckets[kind] = (room - 1.0, now)
            return True
        self._buckets[kind] = (room, now)
        self._missed[kind] = self._missed.get(kind, 0) + 1
        return False

    def missed(self) -> dict[str, int]:
        """Return how many of each kind were not told since the last call."""
        missed, self._missed = self._missed, {}
        return missed
