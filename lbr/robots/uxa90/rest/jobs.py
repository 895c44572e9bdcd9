"""Delayed moves: waiting jobs, their results, and their cancellation. Pure; times are monotonic seconds."""

from collections import OrderedDict
from dataclasses import dataclass, field
from itertools import islice
from typing import Literal

from msgspec import Struct

from lbr.apps.web.face import Refused
from lbr.robots.uxa90.rest.answers import Number
from lbr.robots.uxa90.rest.parsing import Turn

MOST_WAITING = 64
MOST_REMEMBERED = 256
JobState = Literal["waiting", "done", "cancelled", "dropped"]


class JobStep(Struct, frozen=True):
    """One motor of a job: its goal, its delay after the request, and whether it has begun."""

    id: int
    pos: Number
    torq: int
    delay: Number
    begun: bool


class JobData(Struct, frozen=True):
    """A job. `reason` explains why it was dropped or cancelled, or that a step was refused."""

    id: str
    state: JobState
    steps: list[JobStep]
    reason: str = ""


class JobReply(Struct, frozen=True):
    """One job."""

    data: JobData


class JobsReply(Struct, frozen=True):
    """The waiting jobs, and the last ones that ended."""

    data: list[JobData]


@dataclass(slots=True)
class _Job:
    id: str
    begun_s: float
    turns: tuple[Turn, ...]
    waiting: list[int]
    state: JobState = "waiting"
    reason: str = ""
    begun: set[int] = field(default_factory=set)


class Jobs:
    """All waiting jobs, and the newest ended ones."""

    def __init__(self) -> None:
        self._jobs: OrderedDict[str, _Job] = OrderedDict()
        self._count = 0

    @property
    def waiting(self) -> int:
        """Return the number of jobs with steps that have not begun."""
        return sum(job.state == "waiting" for job in self._jobs.values())

    def refuse_more(self) -> None:
        """Refuse a request for one job too many."""
        if self.waiting >= MOST_WAITING:
            raise Refused(429, f"{MOST_WAITING} jobs wait already; cancel some (DELETE /jobs/ID) or ask later")

    def add(self, turns: tuple[Turn, ...], now: float) -> str:
        """Add moves that begin after their delays, and return the job's id; those without one have begun already."""
        self._count += 1
        waiting = sorted((at for at, turn in enumerate(turns) if turn.delay_s > 0.0), key=lambda at: turns[at].delay_s)
        job = _Job(id=str(self._count), begun_s=now, turns=turns, waiting=waiting)
        job.begun = set(range(len(turns))) - set(waiting)
        self._jobs[job.id] = job
        self._forget()
        return job.id

    def due(self, now: float) -> list[tuple[str, tuple[Turn, ...]]]:
        """Return the steps due now, and count them as begun."""
        ready_steps = []
        for job in self._waiting():
            ready = [at for at in job.waiting if now >= job.begun_s + job.turns[at].delay_s]
            if ready:
                job.waiting = job.waiting[len(ready) :]
                job.begun.update(ready)
                job.state = "waiting" if job.waiting else "done"
                ready_steps.append((job.id, tuple(job.turns[at] for at in ready)))
        return ready_steps

    def cancel(self, name: str) -> JobData:
        """Cancel the steps that have not begun."""
        job = self._find(name)
        if job.state != "waiting":
            raise Refused(409, f"Job '{job.id}' is over: {job.state}", code="done")
        job.state, job.reason, job.waiting = "cancelled", "cancelled", []
        return _data(job)

    def drop(self, reason: str, name: str = "") -> int:
        """End one job, or all waiting ones, and return their number."""
        dropped = [job for job in self._waiting() if name in {"", job.id}]
        for job in dropped:
            job.state, job.reason, job.waiting = "dropped", reason, []
        return len(dropped)

    def fail(self, name: str, turns: tuple[Turn, ...], reason: str) -> None:
        """Note that steps did not begin after all, which ends their job."""
        job = self._jobs.get(name)
        if job is not None:
            job.begun -= {at for at, turn in enumerate(job.turns) if any(turn is each for each in turns)}
            job.state, job.reason, job.waiting = "dropped", reason, []

    def get(self, name: str) -> JobData:
        """Return one job."""
        return _data(self._find(name))

    def all(self) -> list[JobData]:
        """Return all jobs, the newest first."""
        return [_data(job) for job in reversed(self._jobs.values())]

    def _find(self, name: str) -> _Job:
        job = self._jobs.get(name)
        if job is None:
            raise Refused(404, f"Job '{name[:40]}' doesn't exist, or was so long ago that it is forgotten")
        return job

    def _waiting(self) -> list[_Job]:
        return [job for job in self._jobs.values() if job.state == "waiting"]

    def _forget(self) -> None:
        """Keep all waiting jobs, and the newest of the others."""
        ended = [job.id for job in self._jobs.values() if job.state != "waiting"]
        for name in islice(ended, max(0, len(ended) - MOST_REMEMBERED)):
            del self._jobs[name]


def _data(job: _Job) -> JobData:
    steps = [
        JobStep(
            id=turn.motor.id,
            pos=turn.position,
            torq=turn.level,
            delay=round(turn.delay_s * 1000.0),
            begun=at in job.begun,
        )
        for at, turn in enumerate(job.turns)
    ]
    return JobData(id=job.id, state=job.state, steps=steps, reason=job.reason)
