"""The position of a replay: it advances with the clock at its speed, pauses, and jumps. Pure."""

SLOWEST, FASTEST = 0.05, 100.0


class Player:
    """Plays from `start_ns` to `end_ns` of a recording; `now` is monotonic seconds."""

    def __init__(self, start_ns: int, end_ns: int, speed: float, now: float) -> None:
        self.start_ns = start_ns
        self.end_ns = end_ns
        self.speed = speed
        self.paused = False
        self._at_ns = start_ns
        self._since = now

    def at_ns(self, now: float) -> int:
        """Return the time of the recording at `now`."""
        gone = 0.0 if self.paused else (now - self._since) * self.speed
        return min(self.end_ns, max(self.start_ns, self._at_ns + round(gone * 1e9)))

    def wait_s(self, ns: int, now: float) -> float:
        """Return the wait until a message of that time is due; infinite during a pause."""
        ahead = (ns - self._at_ns) / 1e9
        return float("inf") if self.paused else ahead / self.speed - (now - self._since)

    def pause(self, now: float, *, paused: bool) -> None:
        """Pause, or go on."""
        self._settle(now)
        self.paused = paused

    def faster(self, now: float, factor: float) -> None:
        """Multiply the speed."""
        self._settle(now)
        self.speed = min(FASTEST, max(SLOWEST, self.speed * factor))

    def seek(self, ns: int, now: float) -> None:
        """Jump to a time, within the recording."""
        self._at_ns, self._since = min(self.end_ns, max(self.start_ns, ns)), now

    def _settle(self, now: float) -> None:
        self._at_ns, self._since = self.at_ns(now), now
