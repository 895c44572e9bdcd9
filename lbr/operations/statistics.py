"""The regularity of a fixed-rate loop, and the time of its next round."""

from math import ceil

from lbr.messages.drive import LoopStatistics

OVERRUN = 1.5
EARLY = 0.1
WINDOW_S = 1.0


class Beat:
    """The schedule of a fixed-rate loop: its rounds are one period apart, whatever else wakes the process."""

    def __init__(self, rate_hz: float, after: float | None = None) -> None:
        self._period_s = 1.0 / rate_hz
        self._due = None if after is None else after + self._period_s

    def due(self, now: float) -> bool:
        """Return whether a round is due, and count it as done."""
        if self._due is None:
            self._due = now
        if now < self._due - EARLY * self._period_s:
            return False
        late = now > self._due + self._period_s / 2
        self._due = (now if late else self._due) + self._period_s
        return True


class LoopMeter:
    """Measures the rounds of a loop, window by window."""

    def __init__(self, rate_hz: float) -> None:
        self._overrun_s = OVERRUN / rate_hz
        self._began: float | None = None
        self._last = 0.0
        self._periods_s: list[float] = []

    def round(self, now: float) -> LoopStatistics | None:
        """Count a round; return the statistics when a window is complete."""
        if self._began is None:
            self._began = self._last = now
            return None
        self._periods_s.append(now - self._last)
        self._last = now
        elapsed_s = now - self._began
        if elapsed_s < WINDOW_S:
            return None
        found = self._statistics(elapsed_s)
        self._began, self._periods_s = now, []
        return found

    def _statistics(self, elapsed_s: float) -> LoopStatistics:
        ordered = sorted(self._periods_s)
        p99_s = ordered[ceil(0.99 * len(ordered)) - 1]
        return LoopStatistics(
            rate_hz=round(len(ordered) / elapsed_s, 2),
            period_p99_ms=round(p99_s * 1000, 2),
            period_max_ms=round(ordered[-1] * 1000, 2),
            overruns=sum(period_s > self._overrun_s for period_s in ordered),
        )
