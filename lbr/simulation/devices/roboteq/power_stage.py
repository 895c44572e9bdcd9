"""The motor side of an emulated Roboteq: two channels behind a watchdog, a stop latch and a mixing mode."""

from collections.abc import Callable

FULL = 1000
"""A command's full scale."""

DEFAULT_WATCHDOG_MS = 1000


class PowerStage:
    """The two outputs, as a function of the commands received and the time.

    Only `feed` keeps the watchdog from expiring. Expiry sets the outputs to zero but keeps the commands: the next
    `feed` restores those of the channels. `works`: the watchdog does.
    """

    def __init__(self, works: Callable[[], bool] = lambda: True) -> None:
        self.commands = [0, 0]
        self.watchdog_ms = DEFAULT_WATCHDOG_MS
        self.mixing = 0
        self.latched = False
        self._works = works
        self._fed_at = 0.0
        self._expired = True

    def feed(self, now: float) -> None:
        """Note a valid runtime command."""
        self._fed_at = now
        self._expired = False

    def expired(self, now: float) -> bool:
        """Return whether the watchdog has cut the outputs; it stays so until fed."""
        if (
            self.watchdog_ms and self._works() and not now - self._fed_at < self.watchdog_ms / 1000
        ):  # this way round, NaN means stop
            self._expired = True
        return self._expired

    def expires_at(self) -> float | None:
        """Return when the watchdog will cut the outputs unless fed, or None if it will not."""
        if self._expired or not (self.watchdog_ms and self._works()):
            return None
        return self._fed_at + self.watchdog_ms / 1000

    def outputs(self, now: float) -> tuple[float, float]:
        """Return both channels' power, -1 to 1."""
        if self.expired(now) or self.latched:
            return (0.0, 0.0)
        first, second = self.commands
        if self.mixing:
            first, second = _clamp(first + second), _clamp(first - second)
        return (first / FULL, second / FULL)


def _clamp(value: int) -> int:
    return max(-FULL, min(FULL, value))
