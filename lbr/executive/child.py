"""One process of ours: started with its document, watched by heartbeat and pidfd, ended for certain."""

import contextlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import IO

import msgspec

from lbr.bus.keys import alive
from lbr.bus.session import leaf_environment
from lbr.capability.config import ProcessConfig, Report
from lbr.capability.program import ProgramSettings
from lbr.capability.reporter import HEARTBEAT_VARIABLE
from lbr.executive.plan import Unit

LOG_LIMIT_BYTES = 2_000_000
_reports = msgspec.json.Decoder(Report)


def open_log(path: Path) -> IO[bytes]:
    """Open a log to append to; one older generation is kept once it is large."""
    if path.exists() and path.stat().st_size > LOG_LIMIT_BYTES:
        path.replace(path.with_suffix(".old.log"))
    return path.open("ab", buffering=0)


def tethered(argv: tuple[str, ...]) -> list[str]:
    """Return the command line that runs `argv` for as long as this process lives.

    To be started from a thread that lives as long as the process: the kernel watches the thread.
    """
    tether = str(Path(__file__).resolve().parent.parent / "capability" / "tether.py")
    return [sys.executable, "-I", "-S", tether, str(os.getpid()), *argv]


class Child:
    """A running process: capability or program."""

    def __init__(self, unit: Unit, config: ProcessConfig, log: IO[bytes]) -> None:
        self.unit = unit
        self._buffer = b""
        self.reports_fd, report_fd = os.pipe()
        os.set_blocking(self.reports_fd, False)
        try:
            self._popen = self._start(unit, config, log, report_fd)
        except BaseException:
            os.close(self.reports_fd)
            raise
        finally:
            os.close(report_fd)
        self.pid = self._popen.pid
        self.pid_fd = os.pidfd_open(self.pid)

    @staticmethod
    def _start(unit: Unit, config: ProcessConfig, log: IO[bytes], report_fd: int) -> "subprocess.Popen[bytes]":
        environment = leaf_environment() | {"LBR_HOME": config.home}
        if unit.program is not None:
            return subprocess.Popen(
                tethered(unit.program.argv),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=environment | program_environment(unit.program, config),
                start_new_session=True,
            )
        popen = subprocess.Popen(
            [sys.executable, "-P", "-m", "lbr.capability.process", f"{config.robot}/{unit.name}"],
            stdin=subprocess.PIPE,
            stdout=log,
            stderr=log,
            env=environment | {HEARTBEAT_VARIABLE: str(report_fd)},
            pass_fds=(report_fd,),
            start_new_session=True,
        )
        assert popen.stdin is not None
        try:
            popen.stdin.write(msgspec.json.encode(config) + b"\n")
            popen.stdin.flush()
        except BrokenPipeError:
            pass  # it died at once; its end is seen where every end is
        return popen

    def reports(self) -> list[Report]:
        """Return what the process has said since the last call; an empty report is a heartbeat."""
        try:
            part = os.read(self.reports_fd, 65536)
        except BlockingIOError:
            return []
        self._buffer = (self._buffer + part)[-65536:]
        *lines, self._buffer = self._buffer.split(b"\n")
        return [_decode(line) for line in lines]

    def terminate(self) -> None:
        """Ask it to end."""
        self._signal(signal.SIGTERM)

    def kill(self) -> None:
        """End it and everything it started."""
        self._signal(signal.SIGKILL)

    def returncode(self) -> int | None:
        """Return how it ended, or None while it runs."""
        return self._popen.poll()

    def close(self) -> None:
        """Let go of its file descriptors after its end."""
        if self._popen.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                self._popen.stdin.close()
        os.close(self.reports_fd)
        os.close(self.pid_fd)

    def _signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, number)


def program_environment(program: ProgramSettings, config: ProcessConfig) -> dict[str, str]:
    """Return what a program of kind `exec` learns about its wiring."""
    return program.env | {
        "LBR_ROBOT": config.robot,
        "LBR_NAME": config.name,
        "LBR_CONNECT": config.endpoints[0],
        "LBR_ALIVE": alive(config.robot, config.name),
        "LBR_INPUTS": json.dumps({port: [wire.key for wire in wires] for port, wires in config.wiring.items()}),
        "LBR_OUTPUTS": json.dumps({port: wires[0].key for port, wires in config.outputs.items()}),
        "LBR_COMMANDS": json.dumps({name: f"{config.robot}/{config.name}/{name}" for name in program.commands}),
    }


def _decode(line: bytes) -> Report:
    if not line:
        return Report()
    try:
        return _reports.decode(line)
    except msgspec.DecodeError:
        return Report()
