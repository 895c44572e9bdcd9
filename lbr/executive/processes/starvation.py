"""A silent process: does it hang, or does it wait for the processor? Pure, except for reading /proc.

The kernel counts how long a runnable thread waits for a processor. A thread that is stopped, waits for a lock, or runs
in an endless loop is not starved. It hangs if its silence is longer than its wait.
"""

import contextlib
from collections.abc import Iterable, Mapping
from math import inf
from pathlib import Path
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

Verdict = Literal["fine", "starved", "hung"]
SUSPICIOUS_S, CALM_SUSPICIOUS_S = 0.3, 0.7
"""A heartbeat comes five times a second, or twice from what moves nothing; after this silence, the threads are looked
at."""
LOOKED_AT_S = 0.5
"""By then a look has happened, unless the looker is delayed as well; the silence before it counts up to here."""
OTHERS_STRETCH = 2.0
"""The main thread may wait for a lock whose holder waits for the processor.

Threads that merely carry messages wait as well, so their waits excuse a silence only up to this multiple of the usual
patience.
"""
HARDLY_S = 0.1
"""A wait up to this is no starvation."""
RUNS_SHARE = 0.25
"""One round of a capability takes some milliseconds of the processor.

If it has used this share of its patience and is still silent, it is in an endless loop, however long it waited. A start
may work for longer.
"""
STARTING_WORK_S = 60.0
"""The processor time for a start: an emulated 64-bit ARM processor needs 17 s for the import of MuJoCo alone."""


class Thread(Struct, frozen=True):
    """The times of a thread so far: it `ran` in so many `slices`, and `waited` for a processor; whether it is
    `runnable`. `since` is when a look first showed this number of slices."""

    ran: float = 0.0
    waited: float = 0.0
    runnable: bool = False
    slices: int = 0
    since: float = -inf


class Look(Struct, frozen=True):
    """The threads of a process at one moment of its silence, with the main thread apart."""

    at: float
    main: Thread = Thread()
    others: Mapping[int, Thread] = {}


def verdict(
    silent_s: float,
    patience_s: float,
    first: Look,
    now: Look,
    *,
    stretch: float = OTHERS_STRETCH,
    may_run_s: float = inf,
    work_s: float = 0.0,
    looked_at_s: float = LOOKED_AT_S,
) -> Verdict:
    """Judge a silence that lasts `silent_s`, with its first look `first` and its latest look `now`.

    The time before the first look has no excuse, but counts only up to `looked_at_s`. A main thread that ran for longer
    than `may_run_s` hangs. Waits of other threads excuse it up to `stretch` times the patience, and its own run time up
    to `work_s`. The verdict is `fine` while patience is left, even if that is only so because the first look came late.
    """
    if not silent_s > patience_s:
        return "fine"
    elapsed = max(0.0, now.at - first.at)
    unseen = min(looked_at_s, max(0.0, silent_s - elapsed))
    main = _waited(first.main, now.main, first.at, now.at)
    both = first.others.keys() & now.others.keys()
    others = [_waited(first.others[one], now.others[one], first.at, now.at) for one in both]
    ran = max(0.0, now.main.ran - first.main.ran)
    if ran > may_run_s:
        return "hung"
    excused = max(main, *others, 0.0) if silent_s <= stretch * patience_s else main
    if unseen + elapsed - excused - min(ran, work_s) > patience_s:
        return "hung"
    return "starved" if excused > HARDLY_S else "fine"


def following(before: Look, now: Look) -> Look:
    """Return a look with the time since each thread's last slice, as far as earlier looks show it.

    A runnable thread has not necessarily waited since the first look: it may have slept, and been woken just now.
    """
    others = {one: _dated(before.others.get(one), thread, now.at) for one, thread in now.others.items()}
    return Look(now.at, _dated(before.main, now.main, now.at), others)


def _dated(before: Thread | None, now: Thread, at: float) -> Thread:
    same = before is not None and before.slices == now.slices
    return replace(now, since=before.since if before is not None and same else at)


def _waited(before: Thread, now: Thread, begun: float, at: float) -> float:
    """Return how long a thread has waited for the processor; the kernel counts a wait only when it is over."""
    elapsed = max(0.0, at - begun)
    waited = max(0.0, now.waited - before.waited)
    if now.runnable:
        left = elapsed - waited - (now.ran - before.ran)
        waited += max(0.0, min(left, at - max(begun, now.since)))
    return min(elapsed, waited)


def waited_s(first: Look, now: Look) -> float:
    """Return how long the main thread has waited for the processor between two looks."""
    return _waited(first.main, now.main, first.at, now.at)


def look(pid: int, at: float, *, all_threads: bool = True, main: int = 0) -> Look:
    """Look at a process, whose main loop runs in the thread `main` or in its first one.

    Without the kernel's counters, or once the process is gone, all waits are zero.
    """
    main = main or pid
    return _seen(_threads(pid) if all_threads else _read([Path(f"/proc/{pid}/task/{main}")]), main, at)


class Looker:
    """Looks as `look` does, and reads a shared process once for all looks of one moment."""

    def __init__(self) -> None:
        self._at = -inf
        self._threads: dict[int, dict[int, Thread]] = {}

    def look(self, pid: int, at: float, *, all_threads: bool = True, main: int = 0) -> Look:
        """Look at a process."""
        if not all_threads:
            return look(pid, at, all_threads=False, main=main)
        if at != self._at:
            self._at = at
            self._threads.clear()
        if pid not in self._threads:
            self._threads[pid] = _threads(pid)
        return _seen(self._threads[pid], main or pid, at)


def _seen(threads: Mapping[int, Thread], main: int, at: float) -> Look:
    others = {number: thread for number, thread in threads.items() if number != main}
    return Look(at, threads.get(main, Thread()), others)


def _threads(pid: int) -> dict[int, Thread]:
    with contextlib.suppress(OSError):
        return _read(Path(f"/proc/{pid}/task").iterdir())
    return {}


def _read(tasks: Iterable[Path]) -> dict[int, Thread]:
    threads: dict[int, Thread] = {}
    for task in tasks:
        with contextlib.suppress(OSError, ValueError, IndexError):
            ran, waited, slices = (task / "schedstat").read_text(encoding="ascii").split()
            state = (task / "stat").read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()[0]
            threads[int(task.name)] = Thread(int(ran) / 1e9, int(waited) / 1e9, state == "R", int(slices))
    return threads
