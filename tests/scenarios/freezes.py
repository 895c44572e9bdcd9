"""Processes that are stopped but not dead, links that break, and a driver that goes together with its guard."""

import ctypes
import os
import signal
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil

from tests.scenarios.clients import plain_client
from tests.scenarios.kills import AFTERMATH_S, kill_process
from tests.support.bench import STARTS_S, Bench, NoMotionError, bench, processes_of
from tests.support.figures import Results

FROZEN_S = 0.6
SYS_PIDFD_GETFD = 438
MANY = 3
"""Ends that a capability may have before its past is forgotten by hand."""


def motor_driver_frozen(under_test: Bench) -> None:
    """S2: its guard ends it."""
    kill_process(under_test, "motors", "S2", number=signal.SIGSTOP)


def drive_frozen(under_test: Bench) -> None:
    """S4: the setpoints grow old; the executive ends it later."""
    kill_process(under_test, "drive", "S4", number=signal.SIGSTOP)


def links_broken(under_test: Bench) -> None:
    """S5: every link of the router breaks at once; it comes back by itself."""
    with _insisting(under_test):
        fault_ns = time.monotonic_ns()
        break_links(under_test.robot.popen.pid)
        zero = under_test.stopped_after("S5", fault_ns)
        _recovered(under_test)
    under_test.stays_at_rest(zero)


def executive_frozen(under_test: Bench) -> None:
    """S7: the executive carries the router; a stubborn sender goes on."""
    with _insisting(under_test):
        fault_ns = under_test.kill(under_test.robot.popen.pid, signal.SIGSTOP)
        zero = under_test.stopped_after("S7", fault_ns)
        under_test.pass_time(FROZEN_S)
        under_test.kill(under_test.robot.popen.pid, signal.SIGCONT)
        _recovered(under_test)
    under_test.stays_at_rest(zero)


def client_frozen(under_test: Bench) -> None:
    """S7: a client that holds a motion is frozen, and goes on later."""
    with plain_client(under_test) as popen:
        try:
            under_test.wait_for_motion(STARTS_S)
            zero = under_test.stopped_after("S7", under_test.kill(popen.pid, signal.SIGSTOP))
            under_test.pass_time(FROZEN_S)
            under_test.kill(popen.pid, signal.SIGCONT)
            under_test.pass_time(AFTERMATH_S)
            under_test.stays_at_rest(zero)
        finally:
            popen.kill()


def everything_frozen(under_test: Bench) -> None:
    """S11: everything but the emulated hardware; only the controller's own watchdog is left."""
    world = under_test.pid("world")
    frozen = [process for process in processes_of(under_test.robot.home) if process.pid != world]
    with _insisting(under_test, frozen):
        fault_ns = time.monotonic_ns()
        _signal(frozen, signal.SIGSTOP)
        zero = under_test.stopped_after("S11", fault_ns)
        under_test.pass_time(FROZEN_S)
        _signal(frozen, signal.SIGCONT)
        _recovered(under_test)
    under_test.stays_at_rest(zero)


def driver_and_guard_killed(under_test: Bench) -> None:
    """S12: the driver and its guard at once."""
    pid = under_test.pid("motors")
    both = [*psutil.Process(pid).children(), psutil.Process(pid)]
    with _insisting(under_test, both):
        fault_ns = time.monotonic_ns()
        _signal(both, signal.SIGKILL)
        zero = under_test.stopped_after("S12", fault_ns)
        _recovered(under_test)
    under_test.stays_at_rest(zero)
    if zero is not None:
        under_test.begins_with_zero(zero.at_ns)  # what was on its way before could not be called back


WAYS: tuple[Callable[[Bench], None], ...] = (
    motor_driver_frozen,
    drive_frozen,
    links_broken,
    executive_frozen,
    client_frozen,
    everything_frozen,
    driver_and_guard_killed,
)


def repeated(*ways: Callable[[Bench], None]) -> Callable[[Results, int], None]:
    """Return a scenario that goes these ways `n` times on one robot."""

    def run(results: Results, n: int) -> None:
        with bench(results) as under_test:
            for turn in range(n):
                if turn and turn % MANY == 0:
                    under_test.forget_deaths("motors")
                    under_test.forget_deaths("drive")
                for way in ways:
                    way(under_test)

    return run


def break_links(pid: int) -> None:
    """Shut every connected socket of a process down, from outside."""
    libc = ctypes.CDLL(None, use_errno=True)
    process = os.pidfd_open(pid)
    for entry in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(OSError):
            if not str(entry.readlink()).startswith("socket:"):
                continue
            taken = libc.syscall(SYS_PIDFD_GETFD, process, int(entry.name), 0)
            if taken < 0:
                raise PermissionError(ctypes.get_errno(), "this needs the right to look into other processes")
            with socket.socket(fileno=taken) as link:
                if link.type == socket.SOCK_STREAM and not link.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN):
                    link.shutdown(socket.SHUT_RDWR)
    os.close(process)


@contextmanager
def _insisting(under_test: Bench, victims: Sequence[psutil.Process] = ()) -> Iterator[None]:
    """Drive with a sender that goes on whatever happens, by processes that have not begun anew meanwhile."""
    mover = under_test.drive()
    try:
        if gone := [victim.pid for victim in victims if not victim.is_running()]:
            raise NoMotionError(f"processes {gone} were gone before")
        yield
    finally:
        mover.cease()


def _recovered(under_test: Bench) -> None:
    under_test.reached()
    under_test.all_ready()
    under_test.pass_time(AFTERMATH_S)


def _signal(processes: list[psutil.Process], number: int) -> None:
    for process in processes:
        with suppress(psutil.Error):
            process.send_signal(number)
