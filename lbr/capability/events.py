"""The rate limit of events: a burst of each kind, then a steady trickle; suppressed events are counted."""

BURST = 20.0
PER_S = 2.0
MOST_KINDS = 256


class Throttle:
    """A token bucket for each kind of event. Pure: the time is an argument."""

    def __init__(self) -> None:
        self._buckets: dict[str, tuple[float, float]] = {}
        self._missed: dict[str, int] = {}

    def take(self, kind: str, now: float) -> bool:
        """Return whether an event of this kind may be published now; count it if not."""
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
        """Return the number of suppressed events of each kind since the last call."""
        missed, self._missed = self._missed, {}
        return missed
