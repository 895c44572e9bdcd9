"""Dates recorded messages by the time they were sent, on one clock that never jumps within a file. Pure.

A file's times are monotonic, with the offset of the wall clock when the file was begun. After a jump of the wall clock
another file is begun.
"""

from collections.abc import Callable

JUMP_NS = 500_000_000
MOST_NS = (1 << 63) - 1
STEADY_S = 600.0


class Clock:
    """Converts stamps to times of a recording; `mono_ns` and `wall_ns` read the clocks of this machine."""

    def __init__(self, boot: str, mono_ns: Callable[[], int], wall_ns: Callable[[], int]) -> None:
        self._boot = boot
        self._mono_ns = mono_ns
        self._wall_ns = wall_ns
        self._apart_ns: dict[str, int] = {}
        self._since_ns = mono_ns()
        self.offset_ns = wall_ns() - mono_ns()
        self.now_ns = mono_ns()

    def look(self) -> int:
        """Read both clocks; return the jump of the wall clock in nanoseconds, or 0."""
        self.now_ns = self._mono_ns()
        offset = self._wall_ns() - self.now_ns
        jump = offset - self.offset_ns
        if abs(jump) < JUMP_NS:
            return 0
        self.offset_ns, self._since_ns = offset, self.now_ns
        return jump

    @property
    def is_steady(self) -> bool:
        """True if the wall clock's last jump is long enough ago that ages can be judged by it."""
        return self.now_ns - self._since_ns > STEADY_S * 1e9

    def sent_ns(self, boot: str, mono_ns: int) -> int:
        """Return when a message was sent, by this machine's monotonic clock; an estimate for another machine."""
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
        """Convert a monotonic time to one of the recording."""
        return min(MOST_NS, max(0, mono_ns + self.offset_ns))
