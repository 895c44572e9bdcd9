"""Rows on trial: kept once all that they touch is ready, otherwise undone, even at the start after a kill.

lbr db apply --within ──► rows and a row of `trial`, in one transaction ──► adopted here ──► ready in time: kept
                                                                                        └─► refused, late: taken back
"""

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from lbr.database import trials
from lbr.database.store import Database
from lbr.database.trials import Trial
from lbr.errors import LbrError
from lbr.executive import threads
from lbr.executive.planning.event_sink import EventSink
from lbr.executive.planning.plan import Change
from lbr.messages.system import CapabilityStatus

STEADY_S = 0.5
"""The time for which all must be ready: a capability that cannot run ends within it, even after it reported ready."""
AGAIN_AFTER_S = 1.0
TOLD = 4


def not_ready(before: Mapping[str, str], touched: Iterable[str], now: Iterable[CapabilityStatus]) -> tuple[str, ...]:
    """Return why rows on trial are not kept yet, as texts: capabilities that they touch, and others that have failed
    since.

    A capability that was degraded before may be so again: the rows do not cause a missing device. Nor do they cause an
    emergency stop.
    """
    statuses = {status.name: status for status in now}
    lacking = []
    for name in touched:
        status = statuses.get(name)
        if status is None:
            lacking.append(f"{name} is not there")
        elif status.phase == "degraded" and (before.get(name) == "degraded" or status.code == "estop"):
            continue
        elif status.phase != "ready":
            lacking.append(f"{name} is {status.phase}" + (f": {status.reason}" if status.reason else ""))
    others = (status for name, status in statuses.items() if name not in touched)
    lacking += [
        f"{status.name} is failed: {status.reason}"
        for status in others
        if status.phase == "failed" != before.get(status.name, "ready")
    ]
    return tuple(lacking)


def go_back(database: Database, robot: str) -> str:
    """Undo the rows that were on trial when a robot's executive ended; return a report for people, or an empty text."""
    trial = trials.newest(database)
    if trial is None or trial.state != "running" or trial.robot != robot:
        return ""
    ended = trials.judge(database, trial, good=False, text="the executive ended before they were judged")
    return outcome(ended)


def outcome(trial: Trial) -> str:
    """Return the result of a trial, for people."""
    done = {
        "kept": f"the rows of revision {trial.revision} are kept",
        "back": f"the rows are as at revision {trial.back} again, because",
        "lost": f"the rows of revision {trial.revision} stay, though",
    }
    return f"{done.get(trial.state, f'revision {trial.revision} is on trial')} {trial.text}".rstrip()


class Trials:
    """Judges the rows on trial of this robot. The main thread calls it; another thread waits for the disk."""

    def __init__(
        self,
        database: Database,
        capabilities: Callable[[], Iterable[CapabilityStatus]],
        happened: EventSink,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._database = database
        self._capabilities = capabilities
        self._happened = happened
        self._clock = clock
        self._before: dict[str, str] = {}
        self._touched: dict[str, None] = {}
        self._looked: object = None
        self._trial: Trial | None = None
        self._until = self._ready_since = 0.0
        self._processes: tuple[tuple[str, int | None, int], ...] = ()
        self._writing: threading.Thread | None = None
        self._ended: Trial | None = None

    @property
    def on(self) -> bool:
        """Return whether rows are on trial: they do not count as good yet."""
        return self._trial is not None

    def touching(self, change: Change) -> None:
        """Note what adopted rows are about to do to the processes."""
        phases: dict[str, str] = {one.name: one.phase for one in self._capabilities()} if change != Change() else {}
        if self._trial is None:
            self._before, self._touched = phases, {}
        names = (*change.start, *change.restart, *change.plug, *change.follow)
        self._touched = {name: None for name in (*self._touched, *names) if name not in change.stop}

    def look(self, robot: str, revision: int, problems: tuple[str, ...]) -> None:
        """Begin and judge what is due; `revision` is of the rows that run, `problems` of those that do not."""
        if self._writing is not None:
            self._end()
        elif self._trial is not None:
            self._step(problems)
        elif self._looked != (revision, problems):
            try:
                trial = trials.newest(self._database)
            except LbrError:
                return  # tried again at the next look
            self._looked = (revision, problems)
            if trial is not None and trial.state == "running" and trial.robot == robot:
                self._begin(trial, problems)

    def _begin(self, trial: Trial, problems: tuple[str, ...]) -> None:
        self._trial, self._until = trial, self._clock() + trial.within_s
        self._ready_since = self._clock()
        text = f"revision {trial.revision} is on trial for {trial.within_s:g} s"
        self._happened("rows_on_trial", "executive", text, data={"revision": trial.revision})
        self._step(problems)

    def _step(self, problems: tuple[str, ...]) -> None:
        now, lacking = self._clock(), problems[:TOLD]
        if lacking:
            self._judge(good=False, text=f"they are refused: {'; '.join(lacking)}")
            return
        capabilities = tuple(self._capabilities())
        lacking = not_ready(self._before, self._touched, capabilities)
        if any(one.phase == "failed" and one.name in self._touched for one in capabilities):
            self._judge(good=False, text="; ".join(lacking[:TOLD]))
            return
        processes = tuple((one.name, one.pid, one.restarts) for one in capabilities)
        if lacking or processes != self._processes:  # a process that ends and restarts may be ready at each look
            self._processes, self._ready_since = processes, now
        if not lacking and now - self._ready_since >= STEADY_S:
            self._judge(good=True, text=f"because {', '.join(self._touched) or 'all'} got ready")
        elif now >= self._until and self._trial is not None:
            why = "; ".join(lacking[:TOLD]) or "they were not ready for long enough"
            self._judge(good=False, text=f"{why} after {self._trial.within_s:g} s")

    def _judge(self, *, good: bool, text: str) -> None:
        trial, path = self._trial, self._database.path

        def write() -> None:
            if trial is not None:
                try:
                    self._ended = _judge(path, trial, good, text)
                except LbrError:
                    time.sleep(AGAIN_AFTER_S)  # the file is locked, or the disk is full

        self._writing = threads.begin(write, "trial")  # if no thread begins, it is judged again at the next look

    def _end(self) -> None:
        if self._writing is None or self._writing.is_alive():
            return
        self._writing = None
        ended, self._ended = self._ended, None
        if ended is None:  # it was not written: judge again
            return
        self._trial, self._looked = None, None
        self._touched = {}
        kind, level = ("rows_kept", "info") if ended.state == "kept" else ("rows_back", "warning")
        self._happened(kind, "executive", outcome(ended), level, data={"revision": ended.revision})


def _judge(path: Path, trial: Trial, good: bool, text: str) -> Trial:
    with Database.open(path, program="executive") as database:
        return trials.judge(database, trial, good=good, text=text)
