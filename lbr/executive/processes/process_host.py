"""The processes that the executive runs, and the capabilities in them: its side of `lbr.capability.process`.

    supervisor ── a Child for each capability ──► Process ── orders ──► the process
                                                          ◄── reports, by number ──┘

A process begins with its first capability and ends with its last. Most have only one. Killing one capability kills all
of its process. A user's program is a process without orders and reports.
"""

import contextlib
import fcntl
import itertools
import os
import select
import signal
from pathlib import Path

import msgspec
from msgspec.structs import replace

from lbr.capability import leaving
from lbr.capability.config import Order, ProcessConfig, Report
from lbr.capability.confine import needs_override
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes import scheduling
from lbr.executive.processes.fork_server import Forked, ForkServer
from lbr.executive.processes.launching import Reports, Running, launch, launch_program
from lbr.executive.processes.logs import open_log
from lbr.executive.processes.reaper import Mark, Reaper

PIPE_BYTES, LARGEST_PIPE_BYTES = 1 << 16, 1 << 20
TERM_S = 0.8
"""The time for a process to end when it is asked to."""
SLOW_S = 5.0
"""The time for a capability whose kill would end others, too: a start, or a device, may be slow."""


class ProcessHost:
    """Starts capabilities, each in its process. `logs` is the directory of their logs."""

    def __init__(self, logs: Path, reaper: Reaper, forks: ForkServer | None = None) -> None:
        self._logs = logs
        self._reaper = reaper
        self._forks = forks
        self._numbers = itertools.count(1)
        self._processes: dict[str, Process] = {}
        self._open: list[Process] = []

    def watch(self, process: "Process") -> None:
        """Have `poll` look at a process from now on."""
        self._open.append(process)

    def poll(self) -> None:
        """Check in one call which processes have news; the others are skipped until the next call."""
        self._open = [process for process in self._open if not process.closed]
        poll = select.poll()
        for fd in {fd for process in self._open for fd in process.fds}:
            poll.register(fd, select.POLLIN)
        ready = {fd for fd, _ in poll.poll(0)}
        for process in self._open:
            process.quiet, process.runs = ready.isdisjoint(process.fds), process.fds[0] not in ready

    def start(self, spec: ProcessSpec, config: ProcessConfig, *, waits: bool = False) -> "Child":
        """Start a capability in its process.

        `waits`: none of the capabilities of the process moves or serves anything. A new process begins if none runs, or
        if the running one may no longer open the device.
        """
        number = next(self._numbers)
        order = b"" if spec.program else _line(Order(number=number, start=config))
        process = self._processes.get(spec.process)
        if process is None or process.over or not process.reaches(config):
            process = self._processes[spec.process] = self._begin(spec, config, waits=waits)
            self.watch(process)
        return process.start(spec, config, number, order)

    def _begin(self, spec: ProcessSpec, config: ProcessConfig, *, waits: bool) -> "Process":
        mark = self._reaper.mark()
        with open_log(self._logs / spec.log) as log:
            if spec.program is not None:
                running, reports = launch_program(spec.program, config, log, mark), Reports(-1)
            else:
                running, reports = launch(spec.process, config, log, mark, self._forks, waits=waits)
        mark.began(running.pid)  # it does nothing before an order comes
        return Process(spec.process, config, running, reports, mark)


class Process:
    """A process with its capabilities. Once it is `over`, nothing begins in it."""

    def __init__(self, name: str, config: ProcessConfig, running: Running, reports: Reports, mark: Mark) -> None:
        self.name = name
        self.culprit: Child | None = None
        """The capability that has ended the process."""
        self.quiet = self.runs = self.closed = False
        """At the last look it had not ended (`runs`), nor reported anything that is still unread (`quiet`)."""
        self._children: dict[int, Child] = {}
        self._override = needs_override(config.places)
        self._running = running
        self._reports = reports
        self._mark = mark
        self._unsent = b""
        self._ends = False
        self._rank = scheduling.Rank(running.pid)
        self.pid = running.pid
        if running.stdin is not None:
            os.set_blocking(running.stdin.fileno(), False)
        try:
            self._pid_fd = os.pidfd_open(self.pid)
        except OSError:
            self._signal(signal.SIGKILL)
            running.wait()
            self._close()
            raise

    @property
    def fds(self) -> tuple[int, ...]:
        """Return the file descriptors with news: of its end, and of its reports."""
        return (self._pid_fd, *self._reports.fds)

    @property
    def over(self) -> bool:
        """Return whether it has ended, or is to end."""
        return self._ends or self.code() is not None

    def reaches(self, config: ProcessConfig) -> bool:
        """Return whether it may open the devices of all capabilities that are to share it."""
        return self._override or not needs_override(config.places)

    def code(self) -> int | None:
        """Return its exit code, or None while it runs."""
        return None if self.runs else self._running.poll()

    def start(self, spec: ProcessSpec, config: ProcessConfig, number: int, order: bytes) -> "Child":
        """Order it to start a capability, and return that."""
        if spec.guarded:
            self._mark.guards(self.pid)
        child = self._children[number] = Child(spec, config, number, self)
        self.rank()
        self._send(order)
        return child

    def end(self, child: "Child") -> None:
        """Ask a capability to end. A frozen process is continued first."""
        self._send(_line(Order(number=child.number)))
        self._end_with_all()
        self._signal(signal.SIGCONT)

    def kill(self, child: "Child") -> None:
        """Kill the process and all that it started, because of one of its capabilities."""
        self._blame(child)
        self._signal(signal.SIGKILL)

    def receive(self) -> None:
        """Hand every capability its reports."""
        self._rank.retry()
        self._send(b"")
        reports, self.quiet = () if self.quiet else self._reports.take(), True
        for report in reports:
            if (child := self._children.get(report.number)) is None:  # it was released
                continue
            child.take(report)
            if child.failed:
                self._blame(child)
            elif report.phase == "ended" and not child.asked:  # the order to end came from elsewhere
                self._ends = True
        self._end_with_all()

    def rank(self) -> None:
        """Set the niceness that its most urgent capability needs."""
        self._rank.set(min(child.niceness for child in self._children.values()))

    def release(self, child: "Child") -> None:
        """Release a capability that has ended. After the last one, kill its remains and close everything."""
        del self._children[child.number]
        if self._children:
            self._end_with_all()
        else:
            self._signal(signal.SIGKILL)
            os.close(self._pid_fd)
            self._close()
            self.closed = True

    def _end_with_all(self) -> None:
        """Ask the process to end, once each of its capabilities has ended or is asked to."""
        if not self.over and all(child.asked or child.left for child in self._children.values()):
            self._ends = True
            self._signal(signal.SIGTERM)

    def _blame(self, child: "Child") -> None:
        self._ends = True
        self.culprit = self.culprit or child

    def _send(self, line: bytes) -> None:
        """Write as much as it accepts now, and keep the rest: a process that does not read must not block anybody."""
        if self._running.stdin is None:
            return
        self._unsent += line
        with contextlib.suppress(OSError):  # it accepts no more now; `poll` notices its end
            if len(line) > PIPE_BYTES:  # unless this user's pipes are used up
                fcntl.fcntl(self._running.stdin, fcntl.F_SETPIPE_SZ, LARGEST_PIPE_BYTES)
        with contextlib.suppress(BlockingIOError, BrokenPipeError):
            while self._unsent:
                self._unsent = self._unsent[os.write(self._running.stdin.fileno(), self._unsent) :]

    def _signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, number)

    def _close(self) -> None:
        if self._running.stdin is not None:
            with contextlib.suppress(OSError):
                self._running.stdin.close()
        if isinstance(self._running, Forked):
            self._running.close()
        self._reports.close()
        self._rank.close()
        self._mark.ended()


class Child:
    """A capability in its process, or a program. `endpoint` is where it connects to the bus."""

    def __init__(self, spec: ProcessSpec, config: ProcessConfig, number: int, process: Process) -> None:
        self.spec = spec
        self.endpoint = next(iter(config.endpoints), "")
        self.number = number
        self.pid = process.pid
        self.asked = False
        """True once it was asked to end."""
        self.left = self.failed = False
        """`left`: it has ended alone; `failed`: its process ends because of it."""
        self._process = process
        self._received: list[Report] = []
        self._thread = 0
        self._settled = self._end_reported = False
        self._code = 0

    @property
    def fds(self) -> tuple[int, ...]:
        """Return the file descriptors with its news, first that of its end."""
        return self._process.fds

    @property
    def thread(self) -> int:
        """Return the kernel's number of its loop's thread; that of its process until the thread is reported."""
        return self._thread or self.pid

    @property
    def has_reports(self) -> bool:
        """Return whether reports of it wait, which came together with another capability's."""
        return bool(self._received)

    @property
    def niceness(self) -> int:
        """Return its niceness now: while it starts, at least the usual rank, as a start is slow on a busy machine."""
        niceness = scheduling.niceness(self.spec)
        return niceness if self._settled else min(niceness, scheduling.USUAL)

    @property
    def patience_s(self) -> float:
        """Return the time for it to end when it is asked to."""
        return TERM_S if self._process.over else SLOW_S

    def take(self, report: Report) -> None:
        """Accept a report. The phase `left` is a failure before its start, which ends it alone."""
        self._thread = report.thread or self._thread
        self.failed = self.failed or report.phase in {"failed", "hung"}
        self.left = self.left or report.phase in {"ended", "left"}
        if report.phase == "left":
            self._code, report = leaving.CRASHED, replace(report, phase="failed")
        self._received.append(report)

    def settle(self) -> None:
        """Note that it is ready for the first time, and lower it to its rank."""
        self._settled = True
        self._process.rank()

    def reports(self) -> list[Report]:
        """Return the reports since the last call; if another capability ended its process, with that one's name."""
        ended = self._process.code() is not None
        self._process.receive()
        reports, self._received = self._received, []
        if ended and not self._end_reported:
            self._end_reported = True
            culprit = self._process.culprit
            if culprit is not None and culprit is not self and not (self.failed or self.left):
                why = f"its process '{self._process.name}' ended with '{culprit.spec.name}', which shares it"
                reports.append(Report(phase="taken_along", reason=why, code="failed"))
        return reports

    def terminate(self) -> None:
        """Ask it to end."""
        self.asked = True
        self._process.end(self)

    def kill(self) -> None:
        """Kill its process, with all that share it."""
        self._process.kill(self)

    def returncode(self) -> int | None:
        """Return its exit code, or None while it runs. The last one has that of the process."""
        if self.left and (self._end_reported or not self._process.over):
            return self._code
        return self._process.code() if self._end_reported else None

    def close(self) -> None:
        """Release it, after its end."""
        self._process.release(self)


def _line(order: Order) -> bytes:
    return msgspec.json.encode(order) + b"\n"
