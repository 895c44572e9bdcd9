"""External commands: programs started by name from the console, one of each at a time. None outlives the executive.

Each gives up the same rights as every process of the robot (capability/confine.py).
"""

import contextlib
import os
import select
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from lbr import home
from lbr.bus.session import leaf_environment
from lbr.bus.stamp import Origin
from lbr.capability.die_with_parent import dying_with_parent
from lbr.database.rows import ExternalCommandRow
from lbr.errors import InputError, LbrError
from lbr.executive.processes import scheduling
from lbr.executive.processes.logs import open_log
from lbr.executive.processes.reaper import Mark, Reaper

BLOCKING_LIMIT_S = 60.0
OUTPUT_LIMIT = 4000
STOP_S = 2.0
CLOSE_S = 0.3
PYTHON = "python"
"""As the program of a row: lbr's own interpreter and packages, without the working directory of `lbr run`."""


@dataclass(frozen=True, slots=True)
class Command:
    """A program that was started for a row, with its mark for the reaper."""

    row: ExternalCommandRow
    popen: "subprocess.Popen[bytes]"
    mark: Mark

    @property
    def pid(self) -> int:
        """Return the number of its process, even after its end."""
        return self.popen.pid

    @property
    def over(self) -> bool:
        """Return whether it has ended."""
        return self.popen.poll() is not None


class ExternalCommands:
    """Starts and stops programs. Only a thread that lives as long as the process may call `start`."""

    def __init__(self, logs: Path, robot: str, reaper: Reaper) -> None:
        self._logs = logs
        self._robot = robot
        self._reaper = reaper
        self._running: dict[str, Command] = {}
        self._asked_at: dict[int, float] = {}

    def start(self, row: ExternalCommandRow, arguments: tuple[str, ...], origin: Origin, said_s: float) -> Command:
        """Start it for a line of an `origin` at `said_s`; raise InputError if it runs, LbrError if it cannot start."""
        known = self._running.get(row.name)
        if known is not None and not known.over:
            raise InputError(f"'{row.name}' runs already (pid {known.pid}); 'stop {row.name}' ends it")
        mark = self._reaper.mark()
        try:
            popen = self._spawn(row, arguments, origin, said_s, mark)
        except OSError as err:
            raise LbrError(f"'{row.name}' could not be started: {err}") from err
        mark.began(popen.pid)
        if known is not None:
            known.mark.ended(spared=not known.row.blocking)
        self._running[row.name] = command = Command(row, popen, mark)
        return command

    def _spawn(
        self, row: ExternalCommandRow, arguments: tuple[str, ...], origin: Origin, said_s: float, mark: Mark
    ) -> "subprocess.Popen[bytes]":
        context = {
            "LBR_ROBOT": self._robot,
            "LBR_NAME": row.name,
            "LBR_STARTED_S": repr(said_s),
            "LBR_ASKED_BY": origin.source,
            "LBR_WRITTEN_S": repr(origin.written_s),
        }
        with contextlib.ExitStack() as stack:
            stdout = subprocess.PIPE if row.blocking else stack.enter_context(open_log(self._logs / f"{row.name}.log"))
            popen = subprocess.Popen(
                dying_with_parent((*_program(row.argv), *arguments), within=str(home.home())),
                stdin=subprocess.DEVNULL,
                stdout=stdout,
                stderr=subprocess.STDOUT,
                env=leaf_environment() | context | mark.environment,
                start_new_session=True,
            )
        scheduling.rank(popen.pid, scheduling.BACKGROUND)
        return popen

    @staticmethod
    def wait(row: ExternalCommandRow, command: Command) -> tuple[int, str]:
        """Wait for a blocking command; return its exit code and the beginning of its output. From any thread."""
        popen = command.popen
        assert popen.stdout is not None
        with popen.stdout:
            output, over = _read(popen.stdout.fileno(), time.monotonic() + BLOCKING_LIMIT_S)
        try:
            popen.wait(STOP_S if over else 0.0)
        except subprocess.TimeoutExpired:
            over = False
        _signal(popen, signal.SIGKILL)
        code = popen.wait()
        command.mark.ended()
        text = output[:OUTPUT_LIMIT].decode(errors="replace").rstrip() + ("\n…" if len(output) > OUTPUT_LIMIT else "")
        if not over:
            late = f"'{row.name}' took longer than {BLOCKING_LIMIT_S:.0f} s and was ended"
            return 1, f"{text}\n{late}" if text else late
        return code, text

    def stop(self, name: str) -> str:
        """End a running command and all that it has started, by force after two seconds. From any thread."""
        command = self._running.get(name)
        if command is None or command.over:
            raise InputError(f"'{name}' does not run")
        popen = command.popen
        _ask(popen)
        try:
            popen.wait(STOP_S)
        except subprocess.TimeoutExpired:
            _signal(popen, signal.SIGKILL)
            popen.wait()
            return f"'{name}' did not end within {STOP_S:.0f} s and was killed"
        finally:
            command.mark.ended()
        return f"'{name}' has ended"

    def prune(self, names: set[str]) -> None:
        """Ask commands whose rows are gone to end, once; kill them after two seconds. Forget those that have ended."""
        now = time.monotonic()
        for name, command in list(self._running.items()):
            if command.over:
                del self._running[name]
                self._asked_at.pop(command.pid, None)
                command.mark.ended(spared=name in names and not command.row.blocking)
            elif name in names:
                self._asked_at.pop(command.pid, None)
            elif command.pid not in self._asked_at:
                self._asked_at[command.pid] = now
                _ask(command.popen)
            elif now - self._asked_at[command.pid] >= STOP_S:
                _signal(command.popen, signal.SIGKILL)

    def close(self) -> None:
        """End them all, within the same third of a second."""
        running = [command.popen for command in self._running.values() if not command.over]
        for popen in running:
            _ask(popen)
        until = time.monotonic() + CLOSE_S
        for popen in running:
            try:
                popen.wait(max(0.0, until - time.monotonic()))
            except subprocess.TimeoutExpired:
                _signal(popen, signal.SIGKILL)
                popen.wait()


def _program(argv: tuple[str, ...]) -> tuple[str, ...]:
    return (sys.executable, "-P", *argv[1:]) if argv[0] == PYTHON else argv


def _read(fd: int, until: float) -> tuple[bytes, bool]:
    """Read to the end, keeping only the beginning; return whether the end came in time."""
    output = b""
    poll = select.poll()
    poll.register(fd, select.POLLIN)
    while poll.poll(max(0.0, until - time.monotonic()) * 1000):
        part = os.read(fd, 65536)
        if not part:
            return output, True
        output += part[: OUTPUT_LIMIT + 1 - len(output)]
        if time.monotonic() > until:
            break
    return output, False


def _ask(popen: "subprocess.Popen[bytes]") -> None:
    """Ask it to end; continue it if it is frozen, so that it receives the signal."""
    _signal(popen, signal.SIGTERM)
    _signal(popen, signal.SIGCONT)


def _signal(popen: "subprocess.Popen[bytes]", number: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(popen.pid, number)
