"""The bound on commands of one sender: 32 at once, and then 200 a second. Pure; the time is an argument.

Senders choose their own names. Names beyond the first 16 within a second share one bound, so that a flood gains nothing
by a new name for each command.
"""

RATE_HZ = 200.0
"""Twice the rate of setpoints for servos, and a tenth of the rate that keeps a mover from its own work."""
BURST = 32
MOST_SENDERS = 16
REMEMBERED_S = 1.0
OTHERS = "\0"


class Inflow:
    """Tracks for each sender until when its share is used up."""

    def __init__(self) -> None:
        self._used_until: dict[str, float] = {}

    def admits(self, sender: str, now: float) -> bool:
        """Return whether one more command of a sender is admitted; count it if so."""
        if sender not in self._used_until and len(self._used_until) >= MOST_SENDERS:
            self._used_until = {name: at for name, at in self._used_until.items() if at + REMEMBERED_S > now}
            if len(self._used_until) >= MOST_SENDERS:
                sender = OTHERS
        used_until = max(self._used_until.get(sender, now), now)
        if used_until - now > (BURST - 1) / RATE_HZ:
            return False
        self._used_until[sender] = used_until + 1 / RATE_HZ
        return True
