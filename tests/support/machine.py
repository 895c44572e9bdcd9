"""What this machine gave: how much of a span of time was left for the tests beside all else that ran, and at what speed.

A bound in a test is meant for a machine that has nothing else to do and is as fast as the one where it was written.
`Stopwatch` tells both times: the clock's, and what this machine gave of it. What is a hard promise is not stretched by
that: it may be measured again where the machine was kept busy, and each time is told at the end of the run (`notes`).
"""

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

PRESSURE = Path("/proc/pressure/cpu")
DELAY = Path("/proc/self/schedstat")
STAT = Path("/proc/stat")
TICKS = os.sysconf("SC_CLK_TCK")

LEAST_SHARE = 0.25
"""A bound is stretched fourfold at most, however busy the machine is: the longest that four busy loops have done to any."""
SLOWEST = 4.0
LOOP = 100_000
LOOP_S = 0.0025
"""What that loop costs on the machine where the bounds were written: two shared cores of a server of 2023."""
BUSY_SHARE = 0.9
"""Below this the machine had more to do than the tests: a hard promise may be measured again."""

notes: list[str] = []
"""What is to be told at the end of the run, by whatever was measured again."""


@dataclass(frozen=True, slots=True)
class Look:
    """A moment, and how long programs have had to wait for a processor until then."""

    at_s: float
    waited_s: float
    stolen_s: float

    @classmethod
    def now(cls) -> "Look":
        """Look at this machine."""
        return cls(time.monotonic(), waited_s(), stolen_s())


def share(began: Look, ended: Look) -> float:
    """Return which share of the time between two moments this machine gave, from a quarter to one."""
    elapsed_s = ended.at_s - began.at_s
    if elapsed_s <= 0.0:
        return 1.0
    withheld_s = ended.waited_s - began.waited_s + ended.stolen_s - began.stolen_s
    return min(1.0, max(LEAST_SHARE, 1.0 - withheld_s / elapsed_s))


class Stopwatch:
    """Measures a span by the clock, and by what this machine gave of it."""

    def __init__(self) -> None:
        self._began = Look.now()

    @property
    def elapsed_s(self) -> float:
        """By the clock."""
        return time.monotonic() - self._began.at_s

    @property
    def share(self) -> float:
        """How much of that this machine gave."""
        return share(self._began, Look.now())

    @property
    def given_s(self) -> float:
        """What a machine with nothing else to do, and as fast as it should be, would have taken."""
        return self.elapsed_s / self.stretch

    @property
    def stretch(self) -> float:
        """How many times as long as it should something may take here."""
        return slowness() / self.share

    def over(self, limit_s: float) -> bool:
        """Say whether a limit has passed, by the clock and by what this machine gave."""
        return self.elapsed_s > limit_s and self.given_s > limit_s

    def __str__(self) -> str:
        return f"{self.elapsed_s:.3f} s by the clock, {self.given_s:.3f} s by what this machine gave"


@cache
def slowness() -> float:
    """Return how many times as long as it should this machine takes for a piece of Python; never less than one."""
    return min(SLOWEST, max(1.0, min(_loop_s() for _ in range(5)) / LOOP_S))


def waited_s() -> float:
    """Return how long some program has had to wait for a processor, or this one where the kernel does not say so."""
    try:
        return int(PRESSURE.read_text().split("total=")[1].split()[0]) * 1e-6
    except (OSError, IndexError, ValueError):
        return _own_delay_s()


def stolen_s() -> float:
    """Return how long the host of a virtual machine has run others on its processors, each processor's share of it."""
    try:
        return int(STAT.read_text().split("\n", 1)[0].split()[8]) / TICKS / (os.cpu_count() or 1)
    except (OSError, IndexError, ValueError):
        return 0.0


def measure_again(complaints: list[str], *, times: int) -> Iterator[int]:
    """Count the tries that a hard promise has; each one more needs a busy machine, and is told with the complaints."""
    for turn in range(times):
        watch = Stopwatch()
        yield turn
        if watch.share > BUSY_SHARE or turn == times - 1:
            return
        notes.append(
            f"{'; '.join(complaints)}: measured again, the machine gave {watch.share:.0%} of {watch.elapsed_s:.1f} s"
        )


def _own_delay_s() -> float:
    try:
        return int(DELAY.read_text().split()[1]) * 1e-9
    except (OSError, IndexError, ValueError):
        return 0.0


def _loop_s() -> float:
    began, total = time.thread_time(), 0
    for n in range(LOOP):
        total += n % 7
    return time.thread_time() - began
