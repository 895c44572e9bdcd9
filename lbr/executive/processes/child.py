"""One process of one capability: started with its document, watched by heartbeat and pidfd, ended for certain."""

import contextlib
import fcntl
import json
import os
import signal
import subprocess
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterable
from pathlib import Path
from typing import IO

import msgspec

from lbr import home
from lbr.bus.codec import Decoder
from lbr.bus.keys import alive
from lbr.bus.session import client_settings, leaf_environment
from lbr.capability.config import NOTHING, ProcessConfig, Report
from lbr.capability.die_with_parent import dying_with_parent
from lbr.capability.program import ProgramSettings
from lbr.capability.reporter import HEARTBEAT_VARIABLE
from lbr.console import token_store
from lbr.errors import MalformedError
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes import scheduling
from lbr.executive.processes.fork_server import Forked, ForkServer
from lbr.executive.processes.managed_process import TERM_S, ManagedProcess, Started
from lbr.executive.processes.reaper import Mark

LARGEST_DOCUMENT_BYTES = 1 << 20
PIPE_BYTES = 1 << 16
HEARTBEATS_S = 0.05
"""What ready processes report is read together, so often, unless they move something; an end is heard at once."""
_reports = Decoder(Report)


class Here(ABC):
    """What runs on this machine, started by this process. `endpoint` is where it comes onto the bus."""

    pid: int
    pid_fd: int
    endpoint: str

    @property
    @abstractmethod
    def fds(self) -> tuple[int, ...]:
        """File descriptors that have news of it."""

    @property
    def thread(self) -> int:
        """The thread that its main loop runs in: a process's first one has its number."""
        return self.pid

    @property
    def patience_s(self) -> float:
        """How long it may take to end when it is asked to."""
        return TERM_S

    @property
    def heard(self) -> bool:
        """Whether there are reports of it that were read already."""
        return False


class Child(Here):
    """A running process: capability or program; `mark` makes it known to the reaper."""

    def __init__(
        self, unit: ProcessSpec, config: ProcessConfig, log: IO[bytes], mark: Mark, forks: ForkServer | None = None
    ) -> None:
        self.unit = unit
        self.endpoint = next(iter(config.endpoints), "")
        self._mark = mark
        self._reports = Reports(-1)
        self._process: subprocess.Popen[bytes] | Forked = (
            self._start_program(unit.program, config, log) if unit.program else self._start(config, log, forks)
        )
        self.pid = self._process.pid
        try:
            self.pid_fd = os.pidfd_open(self.pid)
        except OSError:
            self.kill()
            self._process.wait()
            self._release_files()
            raise

    @property
    def fds(self) -> tuple[int, ...]:
        """File descriptors that have news of it."""
        return (self.pid_fd, *self._reports.fds)

    def _start(
        self, config: ProcessConfig, log: IO[bytes], forks: ForkServer | None
    ) -> "subprocess.Popen[bytes] | Forked":
        document = document_of(config)
        started, self._reports = launch(config, config.name, self._mark, log, forks)
        assert started.stdin is not None
        self._take_rank(started.pid)
        if len(document) > PIPE_BYTES:
            with contextlib.suppress(OSError):  # so that writing never waits for a reader, if this user has pipes left
                fcntl.fcntl(started.stdin, fcntl.F_SETPIPE_SZ, LARGEST_DOCUMENT_BYTES)
        with contextlib.suppress(BrokenPipeError):  # it died at once; its end is seen where every end is
            started.stdin.write(document)
            started.stdin.flush()
        return started

    def _start_program(
        self, program: ProgramSettings, config: ProcessConfig, log: IO[bytes]
    ) -> "subprocess.Popen[bytes]":
        popen = subprocess.Popen(
            dying_with_parent(program.argv, within=config.home),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            env=_environment(config)
            | program_environment(program, config)
            | self._mark.environment
            | {"LBR_CONFIG": str(_way_in(config))},
            start_new_session=True,
        )
        self._mark.began(popen.pid)
        self._take_rank(popen.pid)
        return popen

    def _take_rank(self, pid: int) -> None:
        self._rank = scheduling.Rank(pid)
        self._rank.set(min(scheduling.niceness(self.unit), scheduling.USUAL))

    def settle(self) -> None:
        """Let it fall back to its rank: starting takes a busy machine long enough as it is."""
        self._rank.set(scheduling.niceness(self.unit))

    def reports(self) -> list[Report]:
        """Return what the process has said since the last call; an empty report is a heartbeat."""
        self._rank.retry()
        return self._reports.take()

    def terminate(self) -> None:
        """Ask it to end; one that is frozen goes on, so that it hears."""
        self._signal(signal.SIGTERM)
        self._signal(signal.SIGCONT)

    def kill(self) -> None:
        """End it and everything it started."""
        self._signal(signal.SIGKILL)

    def returncode(self) -> int | None:
        """Return how it ended, or None while it runs."""
        return self._process.poll()

    def close(self) -> None:
        """Free what it holds after its end, and end what it started and left behind."""
        self.kill()
        os.close(self.pid_fd)
        self._release_files()

    def _release_files(self) -> None:
        if self._process.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                self._process.stdin.close()
        if isinstance(self._process, Forked):
            self._process.close()
        self._reports.close()
        self._rank.close()
        self._mark.ended()

    def _signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, number)


def document_of(config: ProcessConfig) -> bytes:
    """Return the line that a process is given; ValueError if it is too long."""
    document = msgspec.json.encode(config) + b"\n"
    if len(document) > LARGEST_DOCUMENT_BYTES:
        raise ValueError(f"its settings and wiring have {len(document)} bytes, more than a process can be given")
    return document


def launch(
    config: ProcessConfig, name: str, mark: Mark, log: IO[bytes], forks: ForkServer | None
) -> "tuple[subprocess.Popen[bytes] | Forked, Reports]":
    """Start the process `name`, which waits for its document on standard input; return it and its reports."""
    words = (f"{config.robot}/{name}", config.home)
    environment = _environment(config) | mark.environment
    reports_fd, report_fd = os.pipe()
    os.set_blocking(reports_fd, False)
    try:
        started: subprocess.Popen[bytes] | Forked | None = None
        if forks is not None and _is_leaf(config):
            started = forks.fork(words, environment, log.fileno(), report_fd)
        if started is None:
            started = subprocess.Popen(
                [sys.executable, "-P", "-m", "lbr.capability.process", *words],
                stdin=subprocess.PIPE,
                stdout=log,
                stderr=log,
                env=environment | {HEARTBEAT_VARIABLE: str(report_fd)},
                pass_fds=(report_fd,),
                start_new_session=True,
            )
    except BaseException:  # also an interruption leaves nothing open; it goes on upwards
        os.close(reports_fd)
        raise
    finally:
        os.close(report_fd)
    mark.began(started.pid)  # before the document comes, it does nothing and hides nothing
    return started, Reports(reports_fd)


def awaited(timeout_s: float, children: Iterable[tuple[ManagedProcess, Started]]) -> tuple[float, list[int]]:
    """Return for how many seconds at most to wait for news of processes, and on which descriptors."""
    fds: set[int] = set()
    for slot, child in children:
        if not isinstance(child, Here):
            continue
        if child.heard:
            timeout_s = 0.0
        if slot.phase == "ready" and not slot.unit.moves:
            timeout_s = min(timeout_s, HEARTBEATS_S)
            fds.add(child.pid_fd)
        else:
            fds.update(child.fds)
    return timeout_s, list(fds)


def _environment(config: ProcessConfig) -> dict[str, str]:
    environment = leaf_environment() if _is_leaf(config) else dict(os.environ)
    environment.pop(token_store.VARIABLE, None)
    return environment | {"LBR_HOME": config.home}


def _is_leaf(config: ProcessConfig) -> bool:
    """Say whether a process opens one session as a leaf; the door to other machines is a router."""
    return config.private == NOTHING


def _way_in(config: ProcessConfig) -> Path:
    """Write down, in Zenoh's own words, how a program gets to the bus as itself; for its owner's eyes only."""
    path = home.directory("run") / f"{config.robot}-{config.name}.json5"
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600), "w") as file:
        json.dump(client_settings(config.endpoints, config.credentials, certificate=config.certificate), file)
    return path


def program_environment(program: ProgramSettings, config: ProcessConfig) -> dict[str, str]:
    """Return what a program of kind `exec` learns about its wiring."""
    return program.env | {
        "LBR_ROBOT": config.robot,
        "LBR_NAME": config.name,
        "LBR_ALIVE": alive(config.robot, config.name),
        "LBR_INPUTS": json.dumps({port: [wire.key for wire in wires] for port, wires in config.wiring.items()}),
        "LBR_OUTPUTS": json.dumps({port: wires[0].key for port, wires in config.outputs.items()}),
        "LBR_COMMANDS": json.dumps({name: f"{config.robot}/{config.name}/{name}" for name in program.commands}),
    }


class Reports:
    """What a process reports, by the pipe that is its alone; -1: none."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._buffer = b""

    @property
    def fds(self) -> tuple[int, ...]:
        """The pipe, while more may come."""
        return (self._fd,) if self._fd >= 0 else ()

    def take(self) -> list[Report]:
        """Return what came since the last call; an empty report is a heartbeat."""
        if self._fd < 0:
            return []
        try:
            part = os.read(self._fd, 65536)
        except BlockingIOError:
            return []
        if not part:  # it closed its end, and will say no more
            self.close()
        self._buffer = (self._buffer + part)[-65536:]
        *lines, self._buffer = self._buffer.split(b"\n")
        return [_decode(line) for line in lines]

    def close(self) -> None:
        """Hear no more."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1


def _decode(line: bytes) -> Report:
    if not line:
        return Report()
    try:
        return _reports.decode(line)
    except MalformedError:
        return Report()
