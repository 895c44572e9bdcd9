"""Dates what is recorded: by the time that each message was sent, on one clock that never jumps within a file. Pure.

A file's times are monotonic ones, moved once to the wall clock as it was when the file was begun. When the wall clock
jumps, another file is begun.
"""

from collections.abc import Callable

JUMP_NS = 500_000_000
MOST_NS = (1 << 63) - 1
STEADY_S = 600.0


class Clock:
    """Turns stamps into times of a recording; `mono_ns` and `wall_ns` read the clocks of this machine."""

    def __init__(self, boot: str, mono_ns: Callable[[], int], wall_ns: Callable[[], int]) -> None:
        self._boot = boot
        self._mono_ns = mono_ns
        self._wall_ns = wall_ns
        self._apart_ns: dict[str, int] = {}
        self._since_ns = mono_ns()
        self.offset_ns = wall_ns() - mono_ns()
        self.now_ns = mono_ns()

    def look(self) -> int:
        """Look at the clocks; return by how many nanoseconds the wall clock has jumped, 0 if it has not."""
        self.now_ns = self._mono_ns()
        offset = self._wall_ns() - self.now_ns
        jump = offset - self.offset_ns
        if abs(jump) < JUMP_NS:
            return 0
        self.offset_ns, self._since_ns = offset, self.now_ns
        return jump

    @property
    def is_steady(self) -> bool:
        """True if the wall clock has gone on evenly for so long that ages may be judged by it."""
        return self.now_ns - self._since_ns > STEADY_S * 1e9

    def sent_ns(self, boot: str, mono_ns: int) -> int:
        """Return when a message was sent, by our monotonic clock; of another machine as near as can be told."""
        if boot == self._boot and boot:
            return mono_ns if 0 < mono_ns <= self.now_ns else self.now_ns
        if not boot or not 0 < mono_ns < MOST_NS:
            return self.now_ns
        apart = self.now_ns - mono_ns
        known = self._apart_ns.get(boot)
        if known is None and len(self._apart_ns) > 64:
            self._apart_ns.clear()
        if known is None or apart < known:
            self._apart_ns[boot] = known = apart
        return min(self.now_ns, mono_ns + known)

    def dated(self, mono_ns: int) -> int:
        """Return a monotonic time as one of the recording."""
        return min(MOST_NS, max(0, mono_ns + self.offset_ns))
