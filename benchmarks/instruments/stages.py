"""When each stage of a command's way was reached, written by the processes on the way into memory that a file backs.

A process writes twenty-four bytes for each: what was reached, a number that goes with it, and the monotonic time. It
costs a microsecond, and nothing where no folder is named in the environment: the shipped code knows nothing of it.
"""

import itertools
import mmap
import os
import struct
import time
from bisect import bisect_left, bisect_right
from collections import defaultdict
from pathlib import Path

FOLDER_VARIABLE = "BENCHMARK_STAGES"
ENTRY = struct.Struct("<qqq")
MOST = 1 << 16

NAMES = (
    "client",
    "arrived",
    "woken",
    "decoded",
    "decided",
    "replied",
    "sent",
    "given",
    "heard",
    "stepped",
    "gated",
    "written",
)
"""In the order of the way; `replied` lies before `sent` or behind `given`."""


class Stamps:
    """One process's; the last 65,536 are kept."""

    def __init__(self, folder: str) -> None:
        self._folder = Path(folder)
        self._memory: mmap.mmap | None = None
        self._counts = itertools.count()

    def reached(self, stage: int, number: int = 0) -> None:
        """Note that a stage was reached now."""
        at_ns = time.monotonic_ns()
        if self._memory is None:  # not before this process has forked off
            with (self._folder / f"{os.getpid()}").open("w+b") as file:
                file.truncate(ENTRY.size * MOST)
                self._memory = mmap.mmap(file.fileno(), ENTRY.size * MOST)
        ENTRY.pack_into(self._memory, ENTRY.size * (next(self._counts) % MOST), stage, number, at_ns)


class Stages:
    """What all processes of a folder have noted, by stage and number."""

    def __init__(self, folder: Path) -> None:
        self._at: dict[str, list[tuple[int, int]]] = defaultdict(list)
        for path in folder.iterdir():
            for stage, number, at_ns in ENTRY.iter_unpack(path.read_bytes()):
                if at_ns:
                    self._at[NAMES[stage]].append((at_ns, number))
        for noted in self._at.values():
            noted.sort()

    def first(self, stage: str, since_ns: int, number: int, before_ns: int) -> int | None:
        """Return when a stage was first reached with a number within a span."""
        noted = self._at[stage]
        for at_ns, found in noted[bisect_left(noted, (since_ns, -1)) :]:
            if at_ns >= before_ns:
                return None
            if found == number:
                return at_ns
        return None

    def last(self, stage: str, before_ns: int) -> int | None:
        """Return when a stage was last reached before a moment."""
        noted = self._at[stage]
        place = bisect_right(noted, (before_ns, 1 << 62))
        return noted[place - 1][0] if place else None
