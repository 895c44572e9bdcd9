"""The time of each stage of a command, written by the processes on its way to memory that a file backs.

A process writes twenty-four bytes for each: the stage, a number for it, and the monotonic time. It costs a microsecond,
and nothing without a folder in the environment: the shipped code does not contain it.
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
"""In the order of the way; `replied` comes before `sent` or after `given`."""


class Stamps:
    """The stages of one process; the last 65,536 are kept."""

    def __init__(self, folder: str) -> None:
        self._folder = Path(folder)
        self._memory: mmap.mmap | None = None
        self._counts = itertools.count()

    def reached(self, stage: int, number: int = 0) -> None:
        """Record that a stage is reached now."""
        at_ns = time.monotonic_ns()
        if self._memory is None:  # not before this process was forked
            with (self._folder / f"{os.getpid()}").open("w+b") as file:
                file.truncate(ENTRY.size * MOST)
                self._memory = mmap.mmap(file.fileno(), ENTRY.size * MOST)
        ENTRY.pack_into(self._memory, ENTRY.size * (next(self._counts) % MOST), stage, number, at_ns)


class Stages:
    """The stages of all processes of a folder, by stage and number."""

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
