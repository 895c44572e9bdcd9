"""The start of a table for a low battery: once each time it gets low, while nobody uses the robot. Pure."""

from math import inf

LOW_FOR_S = 10.0
"""Longer than the voltage sags when a motor starts."""
ALONE_FOR_S = 10.0
"""The time without a motion or a stop by anybody, after which the robot counts as left alone."""


class LowBattery:
    """Decides when to begin the table; call `due` once a round."""

    def __init__(self) -> None:
        self._low_since = inf
        self._alone_since = inf
        self._begun = False

    def due(self, now: float, *, low: bool | None, charging: bool, busy: bool) -> bool:
        """Return whether to begin now; `low` is None if unknown. It is due again only after the battery has been
        charged or was no longer low."""
        if low is False or charging:
            self._begun = False
        self._low_since = min(self._low_since, now) if low and not charging else inf
        self._alone_since = inf if busy else min(self._alone_since, now)
        due = now - self._low_since >= LOW_FOR_S and now - self._alone_since >= ALONE_FOR_S
        if not due or self._begun:
            return False
        self._begun = True
        return True
