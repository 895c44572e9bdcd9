"""Jobs with motions that would block the server's loop, or may be hostile: each runs in a bounded process of its own.

    loop ── job, as a file ──► python -m lbr.apps.motions.commands.work
    loop ◄── lines of JSON ─── progress · result

A job ends early when it is cancelled, is too late, or the server ends. Its process dies with the server.
"""

import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress

import msgspec

from lbr.capability.die_with_parent import dying_with_parent
from lbr.messages.motion_work import CheckJob, Job, JobMessage, NotDone, Progress
from lbr.messages.unreadable import UNREADABLE

PROGRAM = "lbr.apps.motions.commands.work"
MOST_AT_ONCE = 2
"""The most jobs beside the processes that move the robot, on a small machine."""
CHECK_S, SHORT_S = 90.0, 20.0
"""The time for a check (ten minutes of motion, on a machine that takes a seventh of it), and for all other jobs."""
MOST_SAID = 8 << 20
UNASKED_S = 5.0
"""The time without a poll after which a check is cancelled; a page polls four times a second."""
BUSY = NotDone(reason=f"{MOST_AT_ONCE} pieces of work with motions are under way: try again in a moment", code="busy")


class Work:
    """One job; `part` is its progress, `result` its result once it is over."""

    def __init__(self, job: Job, now: float) -> None:
        self.part = 0.0
        self.result: JobMessage | None = None
        self.asked_s = now
        self._until = now + (CHECK_S if isinstance(job, CheckJob) else SHORT_S)
        self._said = b""
        self._process: subprocess.Popen[bytes] | None = None
        try:
            self._process = _started(job)
        except OSError as err:
            self.result = NotDone(reason=f"a process for this cannot be started: {err.strerror}")

    def step(self, now: float) -> None:
        """Read the process's output; end it when it is late, or no longer polled."""
        process = self._process
        if process is None:
            return
        assert process.stdout is not None
        over = process.poll() is not None
        while chunk := _available(process.stdout.fileno()):
            self._said += chunk
        *lines, self._said = self._said.split(b"\n")
        for line in lines:
            self._hear(line)
        if self.result is not None:
            self.end(self.result)
        elif over:
            self.end(NotDone(reason=f"the process that was to do it ended by itself ({process.returncode})"))
        elif now > self._until:
            self.end(NotDone(reason="it took too long, and was ended", code="timeout"))
        elif now - self.asked_s > UNASKED_S:
            self.end(NotDone(reason="it was not asked for any more", code="cancelled"))
        elif len(self._said) > MOST_SAID:
            self.end(NotDone(reason="it sends too much"))

    def end(self, result: JobMessage) -> None:
        """End the process, with this result."""
        self.result = result
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdout is not None
        process.kill()
        process.stdout.close()
        process.wait()

    def _hear(self, line: bytes) -> None:
        try:
            result = msgspec.json.decode(line, type=JobMessage)
        except UNREADABLE as err:
            result = NotDone(reason=f"the answer of the process cannot be read: {err}")
        if isinstance(result, Progress):
            self.part = result.part
        else:
            self.result = result


class Works:
    """The jobs under way, all for the loop; `make` starts one."""

    def __init__(self, clock: Callable[[], float], make: Callable[[Job, float], Work] = Work) -> None:
        self._clock = clock
        self._make = make
        self._under_way: list[Work] = []

    def start(self, job: Job, *, asked: bool = False) -> Work | None:
        """Start a job, unless too many are under way; one with `asked` ends when it is no longer polled."""
        self.step()
        if len(self._under_way) >= MOST_AT_ONCE:
            return None
        work = self._make(job, self._clock())
        if not asked:
            work.asked_s = float("inf")
        self._under_way.append(work)
        return work

    def step(self) -> None:
        """Step all jobs."""
        for work in self._under_way:
            work.step(self._clock())
        self._under_way = [work for work in self._under_way if work.result is None]

    def close(self) -> None:
        """End all jobs."""
        for work in self._under_way:
            work.end(NotDone(reason="the server ends", code="shutting_down"))
        self._under_way = []

    @property
    def count(self) -> int:
        """Return the number of jobs under way."""
        return len(self._under_way)


def _started(job: Job) -> "subprocess.Popen[bytes]":
    """Start the process with the job as its standard input; a file, so that writing never blocks."""
    with os.fdopen(os.memfd_create("motion-work", os.MFD_CLOEXEC), "w+b") as file:
        file.write(msgspec.json.encode(job) + b"\n")
        file.seek(0)
        process = subprocess.Popen(
            dying_with_parent((sys.executable, "-P", "-m", PROGRAM)),
            stdin=file,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            bufsize=0,
        )
    assert process.stdout is not None
    os.set_blocking(process.stdout.fileno(), False)
    return process


def _available(fd: int) -> bytes:
    with suppress(BlockingIOError):
        return os.read(fd, 1 << 20)
    return b""
