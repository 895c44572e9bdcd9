"""Answers requests to change or read rows, beside the main loop and over connections of its own.

capabilities ──► executive.edit ──┐
                                  ├──► one queue ──► a thread ──► the answer, and what it means for what runs
pages ─────────► @manage ─────────┘
"""

from collections import deque
from collections.abc import Callable
from functools import partial
from math import inf
from typing import Any, Protocol

from msgspec import Struct

from lbr.bus import wire
from lbr.errors import InputError, LbrError, MalformedError
from lbr.executive import threads
from lbr.executive.planning.live_rows import LiveRows
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.services import Service
from lbr.messages.codes import Code
from lbr.messages.faces import EditReply
from lbr.messages.manage import ManageReply

MOST_WAITING = 16
Reply = EditReply | ManageReply


class Job(Struct):
    """A request under way: `work` answers it on a thread, `end` returns on the main one whether rows were written.

    `slow` jobs run beside the others. While a job `holds` the rows, other edits wait.
    """

    request: wire.Request
    asked: "Asked"
    work: Callable[[], Reply]
    end: Callable[[Reply], bool]
    slow: bool = False
    holds: bool = False
    reply: Reply | None = None


class Asked(Protocol):
    """One key that the service answers."""

    @property
    def served(self) -> wire.QueryServer:
        """The server of the key, which receives requests."""

    def read(self, request: wire.Request) -> Job:
        """Return the job of a request; InputError or MalformedError refuses it."""

    def refused(self, reason: str, code: Code) -> Any:
        """Return a refusal."""


class RowService(Service):
    """Answers one request after the other. The main thread calls `step`, and a thread waits for the disk."""

    def __init__(self, rows: LiveRows, *asked: Asked, wake: Callable[[], None]) -> None:
        self._rows = rows
        self._asked = asked
        self._wake = wake
        self._waiting: deque[Job] = deque()
        self._running: dict[bool, Job] = {}

    def step(self, _now: float) -> float:
        """Begin and end jobs that are due."""
        for asked in self._asked:
            for request in asked.served.take():
                self._take(asked, request)
        written = False
        for slow, job in list(self._running.items()):
            if job.reply is not None:
                del self._running[slow]
                if job.holds:
                    self._rows.held = False
                written |= job.end(job.reply)
                job.request.reply(job.reply, EXECUTIVE)
        if written:
            self._rows.soon()  # waiting jobs begin once those rows are in force
        else:
            for job in list(self._waiting):
                if job.slow not in self._running:
                    self._begin(job)
        return inf

    def close(self) -> None:
        """Accept no more requests. An edit under way is written, or not, by itself."""
        for asked in self._asked:
            asked.served.close()

    def _take(self, asked: Asked, request: wire.Request) -> None:
        try:
            job = asked.read(request)
        except MalformedError as err:
            request.reply(asked.refused(str(err), "malformed"), EXECUTIVE)
        except InputError as err:
            request.reply(asked.refused(str(err), err.code), EXECUTIVE)
        else:
            if sum(waiting.asked is asked for waiting in self._waiting) < MOST_WAITING:
                self._waiting.append(job)
            else:
                request.reply(asked.refused("too much is asked at once; try again", "busy"), EXECUTIVE)

    def _begin(self, job: Job) -> None:
        self._waiting.remove(job)
        self._running[job.slow] = job
        if job.holds:
            self._rows.held = True
        if threads.begin(partial(self._run, job), "rows") is None:
            job.reply = job.asked.refused(threads.NO_THREAD, "busy")
            self._wake()

    def _run(self, job: Job) -> None:
        try:
            job.reply = job.work()
        except LbrError as err:
            job.reply = job.asked.refused(str(err), err.code if isinstance(err, InputError) else "failed")
        except Exception as err:  # noqa: BLE001 - the sender gets a reply, and the rows are not held for ever
            job.reply = job.asked.refused(f"this is broken: {type(err).__name__}: {err}", "failed")
        self._wake()
