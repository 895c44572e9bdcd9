"""Signals that count for a while after they were last seen. Pure."""

from collections.abc import Hashable
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)


class RecentSignals(Generic[K]):
    """Remembers when each signal was seen last; times are seconds of one monotonic clock."""

    def __init__(self, ttl_s: float) -> None:
        self._ttl_s = ttl_s
        self._seen: dict[K, float] = {}

    def hear(self, signal: K, seen_s: float) -> None:
        """Take note of a signal; an older sight changes nothing."""
        self._seen[signal] = max(seen_s, self._seen.get(signal, seen_s))

    def counts(self, signal: K, now: float) -> bool:
        """Return whether it was seen within the time to live."""
        age_s = self.age_s(signal, now)
        return age_s is not None and age_s < self._ttl_s

    def age_s(self, signal: K, now: float) -> float | None:
        """Return how long ago it was seen, None if never."""
        seen = self._seen.get(signal)
        return None if seen is None else max(0.0, now - seen)
