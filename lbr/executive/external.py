"""External commands: programs started by name from the console, one of each at a time, none outliving the executive.

Each gives up what every process of the robot does (capability/confine.py).
"""

import contextlib
import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

from lbr import home
from lbr.bus.session import leaf_environment
from lbr.capability.tether import tethered
from lbr.database.rows import ExternalCommandRow
from lbr.errors import InputError, LbrError
from lbr.executive import scheduling
from lbr.executive.logs import open_log

BLOCKING_LIMIT_S = 60.0
OUTPUT_LIMIT = 4000
STOP_S = 2.0
PYTHON = "python"
"""As the program of a row: the interpreter that lbr runs on, with lbr's own packages and none of the directory that
`lbr run` was started in."""


class ExternalCommands:
    """Starts and stops programs. `start` must run on the thread that lives as long as the process does."""

    def __init__(self, logs: Path, robot: str) -> None:
        self._logs = logs
        self._robot = robot
        self._running: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, row: ExternalCommandRow, arguments: tuple[str, ...]) -> "subprocess.Popen[bytes]":
        """Start it; raise InputError if it runs already, LbrError if it cannot be started."""
        known = self._running.get(row.name)
        if known is not None and known.poll() is None:
            raise InputError(f"'{row.name}' runs already (pid {known.pid}); 'stop {row.name}' ends it")
        try:
            popen = self._spawn(row, arguments)
        except OSError as err:
            raise LbrError(f"'{row.name}' could not be started: {err}") from err
        self._running[row.name] = popen
        return popen

    def _spawn(self, row: ExternalCommandRow, arguments: tuple[str, ...]) -> "subprocess.Popen[bytes]":
        with contextlib.ExitStack() as stack:
            out = subprocess.PIPE if row.blocking else stack.enter_context(open_log(self._logs / f"{row.name}.log"))
            popen = subprocess.Popen(
                tethered((*_program(row.argv), *arguments), within=str(home.home())),
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=subprocess.STDOUT,
                env=leaf_environment() | {"LBR_ROBOT": self._robot, "LBR_NAME": row.name},
                start_new_session=True,
            )
        scheduling.rank(popen.pid, scheduling.BACKGROUND)
        return popen

    @staticmethod
    def wait(row: ExternalCommandRow, popen: "subprocess.Popen[bytes]") -> tuple[int, str]:
        """Wait for a blocking command; return its exit code and the beginning of what it printed. From any thread."""
        assert popen.stdout is not None
        with popen.stdout:
            output, over = _read(popen.stdout.fileno(), time.monotonic() + BLOCKING_LIMIT_S)
        try:
            popen.wait(STOP_S if over else 0.0)
        except subprocess.TimeoutExpired:
            over = False
        _signal(popen, signal.SIGKILL)
        code = popen.wait()
        if not over:
            return 1, f"'{row.name}' took longer than {BLOCKING_LIMIT_S:.0f} s and was ended"
        text = output[:OUTPUT_LIMIT].decode(errors="replace").rstrip()
        return code, text + ("\n…" if len(output) > OUTPUT_LIMIT else "")

    def stop(self, name: str) -> str:
        """End a running command, by force after two seconds; from any thread."""
        popen = self._running.get(name)
        if popen is None or popen.poll() is not None:
            raise InputError(f"'{name}' does not run")
        _signal(popen, signal.SIGTERM)
        try:
            popen.wait(STOP_S)
        except subprocess.TimeoutExpired:
            _signal(popen, signal.SIGKILL)
            popen.wait()
            return f"'{name}' did not end within {STOP_S:.0f} s and was killed"
        return f"'{name}' has ended"

    def prune(self, names: set[str]) -> None:
        """End commands whose rows are gone, and forget those that have ended by themselves."""
        for name, popen in list(self._running.items()):
            if popen.poll() is not None:
                del self._running[name]
            elif name not in names:
                _signal(popen, signal.SIGTERM)

    def close(self) -> None:
        """End them all."""
        for popen in self._running.values():
            if popen.poll() is None:
                _signal(popen, signal.SIGTERM)
        for popen in self._running.values():
            try:
                popen.wait(0.3)
            except subprocess.TimeoutExpired:
                _signal(popen, signal.SIGKILL)
                popen.wait()


def _program(argv: tuple[str, ...]) -> tuple[str, ...]:
    return (sys.executable, "-P", *argv[1:]) if argv[0] == PYTHON else argv


def _read(fd: int, until: float) -> tuple[bytes, bool]:
    """Read to the end, keeping only the beginning; say whether the end came in time."""
    kept = b""
    poll = select.poll()
    poll.register(fd, select.POLLIN)
    while poll.poll(max(0.0, until - time.monotonic()) * 1000):
        part = os.read(fd, 65536)
        if not part:
            return kept, True
        kept += part[: OUTPUT_LIMIT + 1 - len(kept)]
        if time.monotonic() > until:
            break
    return kept, False


def _signal(popen: "subprocess.Popen[bytes]", number: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(popen.pid, number)
