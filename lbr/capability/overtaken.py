"""Dates messages from another machine by its own stops: a command sent before a stop counts as earlier. Pure.

Clocks of two machines are never compared, so a message from another machine counts from its arrival. A stop overtakes
messages that wait at the door, and would then be older than a command sent before it.
"""

from math import isfinite

from lbr.bus import stamp
from lbr.messages.system import Stamp

REMEMBERED_S = 30.0
"""Longer than the door delays any message. For as long, a stop with a false date blocks its machine's commands."""
MOST_MACHINES = 64


class Overtaken:
    """The last stop of each other machine, by that machine's clock and by ours."""

    def __init__(self) -> None:
        self._stops: dict[str, tuple[float, float]] = {}

    def stopped(self, sent: Stamp | None, arrived: float) -> None:
        """Note a stop; `arrived` is when it came, by our monotonic clock."""
        if sent is None or not _elsewhere(sent) or not isfinite(arrived):
            return
        sent_s, before = sent.mono_ns / 1e9, self._stops.pop(sent.boot, None)
        if before is not None and arrived - before[1] <= REMEMBERED_S:
            sent_s = max(sent_s, before[0])
        self._stops[sent.boot] = sent_s, arrived
        while len(self._stops) > MOST_MACHINES:
            self._stops.pop(next(iter(self._stops)))

    def dated(self, found: Stamp | None, arrived: float) -> float:
        """Return the latest time by our clock at which a command was sent: not after a stop that followed it."""
        stop = self._stops.get(found.boot) if found is not None and _elsewhere(found) else None
        if found is None or stop is None or arrived - stop[1] > REMEMBERED_S or found.mono_ns / 1e9 > stop[0]:
            return arrived
        return min(arrived, stop[1])


def _elsewhere(found: Stamp) -> bool:
    return bool(found.boot) and found.boot != stamp.boot_id()
