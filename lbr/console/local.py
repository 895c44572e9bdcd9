"""The consoles of a process: the robot's own, in a thread of its own, and one on a robot elsewhere."""

import atexit
import contextlib
import os
import stat
import sys
import termios
import threading
import time
from collections.abc import Callable, Iterator
from typing import IO, cast

from lbr import home
from lbr.bus import session
from lbr.console import target
from lbr.console.greeting import Greeting
from lbr.console.interrupt import told_to_leave
from lbr.console.lines import Lines, read
from lbr.console.operator import BusOperator
from lbr.console.outlet import Outlet, Stream
from lbr.messages.system import ConsoleResult

LOCAL_SOURCE = "console"
LEAVE_S = 3.0
READY_S = 120.0
"""On an emulated processor, 15 s were too few. A failure ends the wait at once."""
POLL_S = 0.05
LAST_OUTPUT_S = 1.0


class _Open:
    """The open console of this process, so that it can be closed and waited for."""

    def __init__(self) -> None:
        self.over = threading.Event()
        self.over.set()
        self.leaving = False
        self._close: Callable[[], None] = lambda: None

    def opened(self, close: Callable[[], None]) -> None:
        """Note how to close it; if that was requested meanwhile, close it."""
        self._close = close
        if self.leaving:
            close()

    def leave(self) -> None:
        """Close it, or have it closed as soon as possible."""
        self.leaving = True
        self._close()

    def end(self) -> None:
        """Note that it has closed bus and terminal."""
        self.leaving, self._close = False, lambda: None
        self.over.set()


_open = _Open()


def run_local(
    robot: str,
    connect: Callable[[], session.Session],
    submit: Callable[[str, float], ConsoleResult],
    greeting: Greeting,
) -> int:
    """Run the robot's own console in this thread, until it is left. A terminal shows the `greeting`.

    `submit(line, waited_s)` sends a line directly.
    """
    _open.over.clear()
    atexit.register(leave)  # no thread may be inside the bus library when the interpreter ends
    try:
        with connect() as bus, connect() as streams:
            operator = BusOperator(bus, robot, LOCAL_SOURCE, submit=submit, streams=streams)
            return _run(operator, greeting=greeting)
    finally:
        _open.end()
        atexit.unregister(leave)


def leave() -> None:
    """End the console of this process from another thread, and wait until it has closed bus and terminal."""
    if not _open.over.is_set():
        _open.leave()
        _open.over.wait(LEAVE_S)


def run_remote(place: target.Target, *, hold_s: float | None = None) -> int:
    """Run a console on a robot, until it is left; the robot runs on."""
    with target.connected(place) as bus, target.connected(place) as streams:
        operator = BusOperator(
            bus, place.robot, target.source("console"), role=place.role, proof=place.proof, streams=streams
        )
        return _run(operator, hold_s=hold_s)


def _run(operator: BusOperator, *, greeting: Greeting | None = None, hold_s: float | None = None) -> int:
    try:
        if sys.stdin.isatty() and sys.stdout.isatty():
            return _run_terminal(operator, greeting)
        return _run_lines(operator, local=greeting is not None, hold_s=hold_s)
    finally:
        operator.close()


def _run_lines(operator: BusOperator, *, local: bool, hold_s: float | None) -> int:
    """Run lines from a pipe; unread results are dropped, and only the end waits for their reader."""
    outlet = Outlet()
    output, err = (cast("IO[str]", Stream(outlet, stream.fileno(), strict=True)) for stream in (sys.stdout, sys.stderr))
    lines = Lines(operator, output, err, hold_s=hold_s)
    _open.opened(lines.close)
    try:
        if local:
            _wait_ready(operator, lines)
        code = lines.run(lines_of(sys.stdin.fileno()))
        outlet.drain(LAST_OUTPUT_S if local else None)
        output.flush()
        return code
    finally:
        outlet.close()


def _run_terminal(operator: BusOperator, greeting: Greeting | None) -> int:
    from lbr.console.terminal import Terminal  # noqa: PLC0415 - prompt-toolkit is for those who have a terminal

    if _open.leaving:  # during the imports above
        return 0
    terminal = Terminal(operator, greeting=greeting, history=home.home() / "history")
    _open.opened(terminal.close)
    modes = termios.tcgetattr(sys.stdin)
    try:
        with told_to_leave(terminal.close):
            return terminal.run()
    finally:
        with contextlib.suppress(termios.error, OSError):
            termios.tcsetattr(sys.stdin, termios.TCSANOW, modes)


def _wait_ready(operator: BusOperator, lines: Lines) -> None:
    until = time.monotonic() + READY_S
    while not lines.closing and time.monotonic() < until:
        status = operator.telemetry().status
        if status is not None and (status.ready or any(one.phase == "failed" for one in status.capabilities)):
            return
        time.sleep(POLL_S)


def lines_of(fd: int) -> Iterator[str]:
    """Yield the lines of a file descriptor as they come; bytes that are not UTF-8 are kept as lone surrogates.

    Each has the time at which it was read (`Read`). Lines that are read together, such as a whole file, have one time.
    """
    rest, at = b"", 0.0
    with contextlib.suppress(OSError):
        is_file = stat.S_ISREG(os.fstat(fd).st_mode)
        while chunk := os.read(fd, 65536):
            at = 0.0 if is_file else time.monotonic()
            *lines, rest = (rest + chunk).split(b"\n")
            yield from (read(line.decode(errors="surrogateescape"), at) for line in lines)
    if rest:
        yield read(rest.decode(errors="surrogateescape"), at)
