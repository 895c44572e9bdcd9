"""The start of a process: its program, its environment, and the pipe of its reports."""

import contextlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import IO

from lbr import disk, home
from lbr.bus.codec import Decoder
from lbr.bus.keys import alive
from lbr.bus.session import client_settings, leaf_environment
from lbr.capability.config import NOTHING, ProcessConfig, Report
from lbr.capability.die_with_parent import dying_with_parent
from lbr.capability.program import ProgramSettings
from lbr.capability.reporter import HEARTBEAT_VARIABLE
from lbr.console import token_store
from lbr.errors import MalformedError
from lbr.executive.processes.fork_server import Forked, ForkServer
from lbr.executive.processes.reaper import Mark

Running = subprocess.Popen[bytes] | Forked
_reports = Decoder(Report)


class Reports:
    """The reports of a process, from its own pipe `fd`; -1 without a pipe."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._buffer = b""

    @property
    def fds(self) -> tuple[int, ...]:
        """The pipe, until it is closed."""
        return (self._fd,) if self._fd >= 0 else ()

    def take(self) -> list[Report]:
        """Return the reports since the last call."""
        if self._fd < 0:
            return []
        try:
            part = os.read(self._fd, 65536)
        except BlockingIOError:
            return []
        if not part:  # the process has closed its end
            self.close()
        self._buffer = (self._buffer + part)[-65536:]
        *lines, self._buffer = self._buffer.split(b"\n")
        return [_decode(line) for line in lines]

    def close(self) -> None:
        """Close the pipe."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1


def launch(
    name: str, config: ProcessConfig, log: IO[bytes], mark: Mark, forks: ForkServer | None, *, waits: bool = False
) -> tuple[Running, Reports]:
    """Start the process `name`, which waits for orders on standard input; return it and its reports.

    `waits`: it neither moves nor serves, so it may wait for its input.
    """
    words = (f"{config.robot}/{name}", config.home)
    environment = _environment(config, waits=waits) | mark.environment
    reports_fd, report_fd = os.pipe()
    os.set_blocking(reports_fd, False)
    try:
        started: Running | None = None
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
    except BaseException:  # an interruption, too, must leave nothing open
        os.close(reports_fd)
        raise
    finally:
        os.close(report_fd)
    return started, Reports(reports_fd)


def launch_program(program: ProgramSettings, config: ProcessConfig, log: IO[bytes], mark: Mark) -> Running:
    """Start a user's program."""
    environment = _environment(config) | program_environment(program, config) | mark.environment
    return subprocess.Popen(
        dying_with_parent(program.argv, within=config.home),
        stdin=subprocess.DEVNULL,
        stdout=log,
        stderr=log,
        env=environment | {"LBR_CONFIG": str(_settings_file(config))},
        start_new_session=True,
    )


def program_environment(program: ProgramSettings, config: ProcessConfig) -> dict[str, str]:
    """Return the environment variables that describe its wiring to a program of kind `exec`."""
    return program.env | {
        "LBR_ROBOT": config.robot,
        "LBR_NAME": config.name,
        "LBR_ALIVE": alive(config.robot, config.name),
        "LBR_INPUTS": json.dumps({port: [wire.key for wire in wires] for port, wires in config.wiring.items()}),
        "LBR_OUTPUTS": json.dumps({port: wires[0].key for port, wires in config.outputs.items()}),
        "LBR_COMMANDS": json.dumps({name: f"{config.robot}/{config.name}/{name}" for name in program.commands}),
    }


def _environment(config: ProcessConfig, *, waits: bool = False) -> dict[str, str]:
    environment = leaf_environment(waits=waits) if _is_leaf(config) else dict(os.environ)
    environment.pop(token_store.VARIABLE, None)
    return environment | {"LBR_HOME": config.home}


def _is_leaf(config: ProcessConfig) -> bool:
    """Return whether a process opens one session as a leaf. The door to other machines is a router."""
    return config.private == NOTHING


def _settings_file(config: ProcessConfig) -> Path:
    """Write the Zenoh settings with a program's own credentials. Only their owner may read the file."""
    path = home.directory("run") / f"{config.robot}-{config.name}.json5"
    settings = client_settings(config.endpoints, config.credentials, certificate=config.certificate)
    disk.write(path, json.dumps(settings).encode(), synced=False)
    return path


def _decode(line: bytes) -> Report:
    with contextlib.suppress(MalformedError):
        return _reports.decode(line)
    return Report()
