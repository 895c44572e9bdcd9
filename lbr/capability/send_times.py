"""Dates a stream's messages by our clock, and finds the new ones; also for streams from another machine."""

from collections import deque
from math import inf

from lbr.bus import stamp
from lbr.messages.system import Stamp

WINDOW_S = 10.0
"""Clocks of two machines drift apart by some 0.1 ms/s at most, so an older comparison of them is useless."""
MOST_BOOTS = 16


class SendTimes:
    """The send times of one stream.

    The quickest recent message gives the offset of another machine's clock. So a message that a network has delayed is
    old when it arrives, and does not count as new.
    """

    def __init__(self) -> None:
        self._boot = ""
        self._newest_ns = -1
        self._past: deque[str] = deque(maxlen=MOST_BOOTS)
        self._clock = ""
        self._least_s = self._before_s = inf
        self._turn_s = -inf

    def newer(self, sent: Stamp) -> bool:
        """Return whether a sealed message was sent after all before it; a restart of its machine begins anew."""
        if sent.boot != self._boot:
            if sent.boot in self._past:
                return False
            self._past.append(self._boot)
            self._boot, self._newest_ns = sent.boot, -1
        if sent.mono_ns <= self._newest_ns:
            return False
        self._newest_ns = sent.mono_ns
        return True

    def sent_s(self, sent: Stamp | None, arrived: float) -> float:
        """Return when a message was sent, on our monotonic clock; from another machine, the latest possible time."""
        if sent is None or not sent.boot or sent.boot == stamp.boot_id():
            return stamp.sent_s(sent, arrived)
        if sent.boot != self._clock:
            self._clock, self._least_s, self._turn_s = sent.boot, inf, -inf
        if not arrived < self._turn_s:
            self._before_s, self._least_s, self._turn_s = self._least_s, inf, arrived + WINDOW_S
        self._least_s = min(self._least_s, arrived - sent.mono_ns / 1e9)
        return min(arrived, sent.mono_ns / 1e9 + min(self._least_s, self._before_s))
