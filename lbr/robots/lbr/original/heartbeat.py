"""When a client that moves the robot counts as lost: by what it asked for, and when it was heard since. Pure."""

ATTENDED = 2
"""After so many requests in time a client is taken to attend to what it began."""


class Heartbeat:
    """The silence that a client may keep: `most_s`, and after what ends by itself at first `alone_s`.

    Scripts begin a turn and leave, and a state machine sleeps while it drives for seconds; so what ends by itself may
    go on without its client. One that keeps asking meanwhile, each time in time, shows that it attends: then its
    silence counts as it does always.
    """

    def __init__(self, now: float, most_s: float, alone_s: float = 0.0) -> None:
        self._most_s = most_s
        self._heard = now
        self._alone_until = now + alone_s
        self._in_time = 0

    def beat(self, now: float) -> None:
        """Take note that the client was heard."""
        self._in_time = self._in_time + 1 if now - self._heard <= self._most_s else 0
        self._heard = now

    def silent_s(self, now: float) -> float:
        """Return for how long it has not been heard."""
        return now - self._heard

    def is_lost(self, now: float) -> bool:
        """Return whether it was silent for too long; comparisons are such that NaN is."""
        if now - self._heard <= self._most_s:
            return False
        return self._in_time >= ATTENDED or not now <= self._alone_until
