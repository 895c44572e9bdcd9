"""A clock for what runs in the thread of a test: it stands still while that thread waits for the processor."""

import time
from collections.abc import Callable
from pathlib import Path

SCHEDULED = Path("/proc/thread-self/schedstat")


def own_clock() -> Callable[[], float]:
    """Return monotonic seconds without those for which the thread was ready from now on, and others ran."""
    before_s = _waited_s()

    def clock() -> float:
        while True:
            waited_s, now = _waited_s(), time.monotonic()
            if _waited_s() == waited_s:  # else it waited in between
                return now - (waited_s - before_s)

    return clock


def _waited_s() -> float:
    return int(SCHEDULED.read_text().split()[1]) / 1e9
