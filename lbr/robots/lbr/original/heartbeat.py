"""The loss of a client that moves the robot, by its motion and its signs of life. Pure."""

ATTENDED = 2
"""The number of timely requests after which a client counts as attending."""


class Heartbeat:
    """The silence that a client may keep: `most_s`, and for a motion with an end of its own at first `alone_s`.

    Scripts begin a turn and leave, and a state machine sleeps while it drives for seconds. So a motion with an end of
    its own may continue without its client. A client that keeps asking meanwhile, each time in time, shows that it
    attends. From then on `most_s` applies to its silence.
    """

    def __init__(self, now: float, most_s: float, alone_s: float = 0.0) -> None:
        self._most_s = most_s
        self._beat_at = now
        self._alone_until = now + alone_s
        self._in_time = 0

    def beat(self, now: float) -> None:
        """Count a sign of life."""
        self._in_time = self._in_time + 1 if now - self._beat_at <= self._most_s else 0
        self._beat_at = now

    def silent_s(self, now: float) -> float:
        """Return the time since the last sign of life."""
        return now - self._beat_at

    def is_lost(self, now: float) -> bool:
        """Return whether it was silent for too long; with NaN in a comparison it was."""
        if now - self._beat_at <= self._most_s:
            return False
        return self._in_time >= ATTENDED or not now <= self._alone_until
