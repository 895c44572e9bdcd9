"""A process that several capabilities share: the executive's side of `lbr.capability.shared_process`.

    supervisor ── one Member for each capability ──► SharedChild ── orders ──► the process
                                                                ◄── reports, by name ──┘

It begins with the first capability, and is ended with the last. To kill one of them is to kill it.
"""

import contextlib
import os
import signal
from collections import deque
from collections.abc import Callable
from typing import IO

import msgspec
from msgspec.structs import replace

from lbr.capability import leaving
from lbr.capability.config import Order, ProcessConfig, Report
from lbr.capability.confine import needs_override
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes import scheduling
from lbr.executive.processes.child import Here, document_of, launch
from lbr.executive.processes.fork_server import Forked, ForkServer
from lbr.executive.processes.reaper import Mark

LAST_REPORTS = frozenset({"failed", "hung"})
SLOW_S = 5.0
"""A capability that is asked to end gets longer where others would end with it: a start, or a device, may take its
time."""


class SharedProcesses:
    """The processes that are shared now, by their names."""

    def __init__(self) -> None:
        self._children: dict[str, SharedChild] = {}
        self._gone: list[SharedChild] = []

    def start(
        self,
        unit: ProcessSpec,
        config: ProcessConfig,
        log: Callable[[], IO[bytes]],
        mark: Callable[[], Mark],
        forks: ForkServer | None = None,
    ) -> "Member":
        """Start a capability in its process, which begins if it is not there, or could not open the capability's
        device.

        In that case the others stay in the one of before, which has given up the right to.
        """
        self.sweep()
        document_of(config)  # one that is too long begins nothing
        child = self._children.get(config.process)
        if child is None or child.ended or not child.reaches(config):
            with log() as file:
                child = SharedChild(config, file, mark(), forks, self._done)
            self._children[config.process] = child
        return child.begin(unit, config)

    def sweep(self) -> None:
        """Free what is held for processes that have ended."""
        self._gone = [child for child in self._gone if not child.freed()]

    def _done(self, child: "SharedChild") -> None:
        if self._children.get(child.name) is child:
            del self._children[child.name]
        self._gone.append(child)


class SharedChild:
    """One of them; `done` is called when its last capability has gone."""

    def __init__(
        self,
        config: ProcessConfig,
        log: IO[bytes],
        mark: Mark,
        forks: ForkServer | None,
        done: Callable[["SharedChild"], None],
    ) -> None:
        self.name = config.process
        self._override = needs_override(_places(config))
        self._mark = mark
        self._done = done
        self._process, self.reports = launch(config, self.name, mark, log, forks)
        self.pid = self._process.pid
        self._stdin = self._process.stdin
        assert self._stdin is not None
        os.set_blocking(self._stdin.fileno(), False)
        self._unsent = b""
        self._fresh = True
        self._members: dict[str, Member] = {}
        self._rank = scheduling.Rank(self.pid)
        self._leaves = False
        self.because = ""
        """Whose end was its end."""
        try:
            self.pid_fd = os.pidfd_open(self.pid)
        except OSError:
            self.kill("")
            self._process.wait()
            self._release()
            raise

    @property
    def ended(self) -> bool:
        """Whether nothing more can begin there."""
        over = self._leaves or bool(self.because) or self.code() is not None
        return over or not (self._members or self._fresh)

    def reaches(self, config: ProcessConfig) -> bool:
        """Say whether it may open what those who are to share it now have for devices."""
        return self._override or not needs_override(_places(config))

    @property
    def alone(self) -> bool:
        """Whether it has one capability, or none."""
        return len(self._members) < 2

    def code(self) -> int | None:
        """Return how it ended, or None while it runs."""
        return self._process.poll()

    def begin(self, unit: ProcessSpec, config: ProcessConfig) -> "Member":
        """Have it begin with one more capability."""
        if unit.guarded:
            self._mark.guards(self.pid)
        self._send(document_of(config) if self._fresh else _line(Order(start=config)))
        self._fresh = False
        member = self._members[unit.name] = Member(unit, config, self)
        self.rank()
        return member

    def stop(self, name: str) -> None:
        """Ask one of its capabilities to end; if it is frozen, it goes on, so that it hears."""
        self._send(_line(Order(stop=name)))
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGCONT)

    def kill(self, because: str) -> None:
        """End it, because of one of its capabilities."""
        self.because = self.because or because
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)

    def hear(self) -> None:
        """Give every capability what was reported of it."""
        self._rank.retry()
        self._send(b"")
        for report in self.reports.take():
            if report.phase in LAST_REPORTS:
                self.because = self.because or report.capability
            member = self._members.get(report.capability)
            if member is not None:
                self._leaves = self._leaves or (report.phase == "ended" and not member.asked)
                member.take(report)

    def rank(self) -> None:
        """Give it the niceness of the one that needs the best."""
        wanted = [member.niceness for member in self._members.values()]
        if wanted:
            self._rank.set(min(wanted))

    def leave(self, name: str) -> None:
        """Let a capability that has ended go; nothing is left to run with the last."""
        del self._members[name]
        if not self._members:
            self.kill(name)
            self._done(self)

    def freed(self) -> bool:
        """Free what is held for it, if it has ended."""
        if self.code() is None:
            return False
        os.close(self.pid_fd)
        self._release()
        return True

    def _release(self) -> None:
        with contextlib.suppress(OSError):
            if self._stdin is not None:
                self._stdin.close()
        if isinstance(self._process, Forked):
            self._process.close()
        self.reports.close()
        self._rank.close()
        self._mark.ended()

    def _send(self, line: bytes) -> None:
        """Write what it takes now, and keep the rest for later: who does not read holds up nobody."""
        self._unsent += line
        with contextlib.suppress(BlockingIOError, BrokenPipeError):  # its end is seen where every end is
            while self._unsent and self._stdin is not None:
                self._unsent = self._unsent[os.write(self._stdin.fileno(), self._unsent) :]


class Member(Here):
    """A capability in a process that it shares."""

    def __init__(self, unit: ProcessSpec, config: ProcessConfig, shared: SharedChild) -> None:
        self.unit = unit
        self.endpoint = next(iter(config.endpoints), "")
        self.pid, self.pid_fd = shared.pid, shared.pid_fd
        self._shared = shared
        self._heard: deque[Report] = deque()
        self._thread = 0
        self._settled = self._ended = self._failed = self._said_why = self._told = False
        self.asked = False
        """Whether it was asked to end; one that ends unasked leaves with all the others."""

    @property
    def fds(self) -> tuple[int, ...]:
        """File descriptors that have news of it."""
        return (self.pid_fd, *self._shared.reports.fds)

    @property
    def thread(self) -> int:
        """The thread of its loop, once it has said so."""
        return self._thread or self.pid

    @property
    def heard(self) -> bool:
        """Whether reports of it wait that came together with another's."""
        return bool(self._heard)

    @property
    def niceness(self) -> int:
        """The niceness that it needs now."""
        found = scheduling.niceness(self.unit)
        return found if self._settled else min(found, scheduling.USUAL)

    def take(self, report: Report) -> None:
        """Take a report of it; one that has left has failed before it began, and has ended alone."""
        self._thread = report.thread or self._thread
        self._ended = self._ended or report.phase in {"ended", "left"}
        self._failed = self._failed or report.phase == "left"
        self._said_why = self._said_why or report.phase in LAST_REPORTS
        self._heard.append(replace(report, phase="failed") if report.phase == "left" else report)

    def settle(self) -> None:
        """Let it fall back to its rank."""
        self._settled = True
        self._shared.rank()

    def reports(self) -> list[Report]:
        """Return what it has said since the last call; of an end that was another's doing, whose."""
        ended = self._shared.code() is not None
        self._shared.hear()
        found = list(self._heard)
        self._heard.clear()
        if ended and not self._told:
            self._told = True
            because = self._shared.because
            if because not in {"", self.unit.name} and not self._said_why:
                why = f"its process '{self._shared.name}' ended with '{because}', which shares it"
                found.append(Report(phase="taken_along", reason=why, code="failed"))
        return found

    @property
    def patience_s(self) -> float:
        """How long it may take to end when it is asked to."""
        return super().patience_s if self._shared.alone else SLOW_S

    def terminate(self) -> None:
        """Ask it to end."""
        self.asked = True
        self._shared.stop(self.unit.name)

    def kill(self) -> None:
        """End the process, and all that share it."""
        self._shared.kill(self.unit.name)

    def returncode(self) -> int | None:
        """Return how it ended, or None while it runs."""
        if self._ended:
            return leaving.CRASHED if self._failed else 0
        return self._shared.code() if self._told else None

    def close(self) -> None:
        """Let it go, after its end."""
        self._shared.leave(self.unit.name)


def _places(config: ProcessConfig) -> tuple[str, ...]:
    return (config.home, *config.reach)


def _line(order: Order) -> bytes:
    return msgspec.json.encode(order) + b"\n"
