"""When a table begins by itself because the battery is low: once each time that it gets low, while the robot is left
alone. Pure."""

from math import inf

LOW_FOR_S = 10.0
"""A voltage sags for seconds when a motor starts."""
ALONE_FOR_S = 10.0
"""Nobody has moved or stopped the robot for so long."""


class LowBattery:
    """Told what is seen once a round, it says when to begin."""

    def __init__(self) -> None:
        self._low_since = inf
        self._alone_since = inf
        self._begun = False

    def due(self, now: float, *, low: bool | None, charging: bool, busy: bool) -> bool:
        """Return whether to begin now; `low` null: not known. After it began, only a battery that was well again
        counts."""
        if low is False or charging:
            self._begun = False
        self._low_since = min(self._low_since, now) if low and not charging else inf
        self._alone_since = inf if busy else min(self._alone_since, now)
        due = now - self._low_since >= LOW_FOR_S and now - self._alone_since >= ALONE_FOR_S
        if not due or self._begun:
            return False
        self._begun = True
        return True
