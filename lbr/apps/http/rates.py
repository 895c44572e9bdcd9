"""Limits the rate of each client's requests."""

from collections import OrderedDict

MOST_KNOWN = 1024


class Bucket:
    """A token bucket: `rate_hz` tokens a second; it holds `at_once`, by default a quarter second's but at least one."""

    def __init__(self, rate_hz: float, now: float, at_once: float = 0.0) -> None:
        self._rate_hz = rate_hz
        self._most = self._tokens = at_once or max(rate_hz / 4, 1.0)
        self._at = now

    def take(self, now: float) -> bool:
        """Take a token; return False without one."""
        self._tokens = min(self._most, self._tokens + (now - self._at) * self._rate_hz)
        self._at = now
        if not self._tokens >= 1.0:
            return False
        self._tokens -= 1.0
        return True


class Rates:
    """A bucket for each of the newest clients."""

    def __init__(self, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._buckets: OrderedDict[str, Bucket] = OrderedDict()

    def take(self, client: str, now: float) -> bool:
        """Return whether a client may send a request now."""
        bucket = self._buckets.get(client)
        if bucket is None:
            bucket = self._buckets[client] = Bucket(self._rate_hz, now)
            if len(self._buckets) > MOST_KNOWN:
                self._buckets.popitem(last=False)
        self._buckets.move_to_end(client)
        return bucket.take(now)
