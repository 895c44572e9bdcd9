"""A process that is silent: does it hang, or does the machine not give it the processor? Pure, but for the reading.

A thread that could run and is not given a processor is waiting, and the kernel counts how long. A thread that is
stopped, waits for a lock, or turns in circles is not starved: one that is silent for longer than it waited hangs.
"""

import contextlib
from collections.abc import Iterable, Mapping
from math import inf
from pathlib import Path
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

Verdict = Literal["fine", "starved", "hung"]
SUSPICIOUS_S = 0.3
"""A heartbeat comes five times a second; from here on it is looked at who has the processor."""
LOOKED_AT_S = 0.5
"""By then it has been, unless who looks is held up as well; what went before is counted up to here."""
OTHERS_STRETCH = 2.0
"""The main thread may wait for what another thread of its process holds while that is not given the processor; but
threads that merely carry messages wait as well, so this excuses no longer than this many times the usual patience."""
HARDLY_S = 0.1
"""The longest wait of any thread."""
RUNS_SHARE = 0.25
"""A round of a capability that runs takes some milliseconds of the processor. One that has had a quarter of its
patience, and is silent for longer than that, turns in circles, however long it waited; one that starts may have much to
do."""
STARTING_WORK_S = 60.0
"""So long a start may work: an emulated 64-bit ARM processor needs 17 s for the import of MuJoCo alone."""


class Thread(Struct, frozen=True):
    """The times of a thread so far: how long it `ran`, in how many `slices`, how long it `waited` for a processor, and
    whether it could run. `since` is when it was first seen to have had so many slices."""

    ran: float = 0.0
    waited: float = 0.0
    runnable: bool = False
    slices: int = 0
    since: float = -inf


class Look(Struct, frozen=True):
    """A process at one moment of its silence: how long it had been silent, and its threads, the main one apart."""

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
) -> Verdict:
    """Judge a silence that lasts `silent_s`, of which `first` was the first look and `now` is the latest.

    Nothing excuses what went before the first look, but it counts no longer than a look should have taken to come. A
    thread that ran for longer than `may_run_s` hangs. `stretch` is for how many times the patience threads beside the
    main one excuse it; running itself excuses it for `work_s`. With patience left `fine`, also where it is only because
    the first look came late.
    """
    if not silent_s > patience_s:
        return "fine"
    elapsed = max(0.0, now.at - first.at)
    unseen = min(LOOKED_AT_S, max(0.0, silent_s - elapsed))
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
    """Return a look that knows of each thread for how long it has had no slice, as far as the looks before tell.

    A thread that is seen able to run has not waited ever since the first look: it may have slept, and been woken just
    now.
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

    A kernel that counts nothing, or a process that is gone, has waited for nothing.
    """
    main = main or pid
    return _seen(_threads(pid) if all_threads else _read([Path(f"/proc/{pid}/task/{main}")]), main, at)


class Looker:
    """Looks as `look` does, and reads a process that several share once for all looks of one moment."""

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
