"""The one thread that owns a servo bus: jobs queue for it, stops first, then writes, then reads.

    thread = BusThread(bus, background)
    thread.start()
    thread.submit(lambda bus: bus.put(1, table.LED, 1), WRITE).result()

`background` does one transaction of the poller and returns the seconds until the next. A job is one transaction or a
few; a stop is on the wire as soon as the current job has ended.
"""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Generic, TypeVar

STOP, WRITE, READ = 0, 1, 2
Bus = TypeVar("Bus")
T = TypeVar("T")
_Jobs = dict[object, tuple[Callable[[object], object], "Future[object]"]]


class BusThread(Generic[Bus]):
    """Runs jobs by priority, and the background between them. An error of the line ends the thread: see `failure`."""

    def __init__(self, bus: Bus, background: Callable[[Bus], float] = lambda _bus: 60.0) -> None:
        self.failure: Exception | None = None
        self._bus = bus
        self._background = background
        self._jobs: tuple[_Jobs, _Jobs, _Jobs] = ({}, {}, {})
        self._changed = threading.Condition()
        self._ending = False
        self._thread = threading.Thread(target=self._run, name="servo bus", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def submit(self, job: Callable[[Bus], T], priority: int, key: object = None) -> "Future[T]":
        """Queue a job, from any thread; a job with a key replaces a waiting job with the same key."""
        future: Future[T] = Future()
        with self._changed:
            if self._ending or self.failure is not None:
                future.cancel()
                return future
            jobs = self._jobs[priority]
            if key in jobs:
                jobs[key][1].cancel()
            jobs[future if key is None else key] = (job, future)  # type: ignore[assignment]
            self._changed.notify()
        return future

    def urgent(self) -> bool:
        """Return whether a stop waits; the bus checks it while it waits for an answer."""
        return bool(self._jobs[STOP]) or self._ending

    def waiting(self, priority: int) -> bool:
        """Return whether a job of that priority waits."""
        return bool(self._jobs[priority])

    def join(self, within_s: float) -> bool:
        """Do the waiting jobs, then end the thread; return whether it ended in time."""
        with self._changed:
            self._ending = True
            self._changed.notify()
        if self._thread.is_alive():
            self._thread.join(within_s)
        return not self._thread.is_alive()

    def turn(self, wait_s: float = 0.0) -> float | None:
        """Do the next job that arrives in this time, else the background's turn; return the seconds to its next, None
        at the end."""
        taken = self._next(wait_s)
        if taken is not None:
            self._do(*taken)
            return 0.0
        return None if self._ending else self._background(self._bus)

    def _run(self) -> None:
        try:
            wait_s: float | None = 0.0
            while wait_s is not None:
                wait_s = self.turn(wait_s)
        except Exception as err:  # noqa: BLE001  the owner of this thread raises it in its own
            self._fail(err)

    def _next(self, wait_s: float) -> tuple[Callable[[Bus], object], "Future[object]"] | None:
        """Return the next job, or None for the background's turn."""
        if not any(self._jobs) and not wait_s > 0.0 and not self._ending:
            return None
        with self._changed:
            if not any(self._jobs) and not self._ending:
                self._changed.wait(wait_s)
            for jobs in self._jobs:
                if jobs:
                    return jobs.pop(next(iter(jobs)))
        return None

    def _do(self, job: Callable[[Bus], object], future: "Future[object]") -> None:
        if not future.set_running_or_notify_cancel():
            return
        try:
            future.set_result(job(self._bus))
        except Exception as err:
            future.set_exception(err)
            if isinstance(err, OSError):
                raise

    def _fail(self, err: Exception) -> None:
        with self._changed:
            self.failure = err
            for jobs in self._jobs:
                for _, future in jobs.values():
                    future.cancel()
                jobs.clear()
