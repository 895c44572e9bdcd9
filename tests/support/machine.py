"""How much of a span of time this machine gave to what was measured, beside all else that ran on it."""

import os
import time
from dataclasses import dataclass
from pathlib import Path

PRESSURE = Path("/proc/pressure/cpu")
STAT = Path("/proc/stat")
TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True, slots=True)
class Moment:
    """A moment, and how long programs have had to wait for a processor until then."""

    at_s: float
    waited_s: float
    stolen_s: float

    @classmethod
    def now(cls) -> "Moment":
        """Read it off this machine."""
        return cls(time.monotonic(), _waited_s(), _stolen_s())


def share(began: Moment, ended: Moment) -> float:
    """Return which share of the time between two moments this machine gave, from 0 to 1."""
    elapsed_s = ended.at_s - began.at_s
    if elapsed_s <= 0.0:
        return 1.0
    withheld_s = ended.waited_s - began.waited_s + ended.stolen_s - began.stolen_s
    return min(1.0, max(0.0, 1.0 - withheld_s / elapsed_s))


def _waited_s() -> float:
    """Return how long some program has had to wait for a processor; 0 where the kernel does not report it."""
    try:
        return int(PRESSURE.read_text().split("total=")[1].split()[0]) * 1e-6
    except (OSError, IndexError, ValueError):
        return 0.0


def _stolen_s() -> float:
    """Return how long the host of a virtual machine has run others on its processors, per processor."""
    try:
        return int(STAT.read_text().split("\n", 1)[0].split()[8]) / TICKS / (os.cpu_count() or 1)
    except (OSError, IndexError, ValueError):
        return 0.0
