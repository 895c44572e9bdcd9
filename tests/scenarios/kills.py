"""Processes killed while the robot drives."""

import signal
import time

import psutil

from tests.support.bench import Bench, bench, processes_of
from tests.support.figures import Results
from tests.support.waiting import HANG_S

DEATHS_BEFORE_FORGETTING = 3
AFTERMATH_S = 0.25
OTHERS = ("ranges", "world")
APART = ("UPDATE capability SET process = '' WHERE robot = 'lbr'",)


def kill_process(
    under_test: Bench, name: str, figure: str, ready_figure: str = "", *, number: int = signal.SIGKILL
) -> None:
    """Kill (or freeze) one capability's process; the old lease goes on being renewed until well after the new one is ready."""
    pid = under_test.pid(name)
    mover = under_test.drive()
    try:
        fault_ns = under_test.kill(pid, number)
        zero = under_test.stopped_after(figure, fault_ns)
        under_test.ready_again(name, pid, fault_ns, ready_figure)
        under_test.pass_time(AFTERMATH_S)
    finally:
        mover.cease()
    under_test.stays_at_rest(zero)
    if name == "motors" and zero is not None:
        under_test.begins_with_zero(zero.at_ns)  # what was on its way before could not be called back


def kill_motor_driver(results: Results, n: int) -> None:
    """S1, P1."""
    _many(results, n, "motors", "S1")


def kill_drive(results: Results, n: int) -> None:
    """S3, P1."""
    _many(results, n, "drive", "S3")


def hurt_drive_apart(results: Results, n: int) -> None:
    """S3, S4 where drive and motor driver have a process each."""
    _many(results, n, "drive", "S3", edits=APART)
    with bench(results, edits=APART) as under_test:
        kill_process(under_test, "drive", "S4", number=signal.SIGSTOP)


def _many(results: Results, n: int, name: str, figure: str, *, edits: tuple[str, ...] = ()) -> None:
    with bench(results, edits=edits) as under_test:
        for turn in range(n):
            if turn and turn % DEATHS_BEFORE_FORGETTING == 0:
                under_test.forget_deaths(name)
            kill_process(under_test, name, figure, f"P1 {name}" if turn % DEATHS_BEFORE_FORGETTING == 0 else "")


def kill_others(results: Results, n: int) -> None:
    """P1 of what moves nothing by itself: a standing robot, so that only the recovery counts."""
    with bench(results) as under_test:
        for turn in range(n):
            for name in OTHERS:
                under_test.all_ready()
                pid = under_test.pid(name)
                under_test.ready_again(name, pid, under_test.kill(pid), f"P1 {name}")
                if turn < n - 1:
                    under_test.forget_deaths(name)


def kill_executive(results: Results, n: int) -> None:
    """S6."""
    for _ in range(n):
        with bench(results) as under_test:
            executive_killed(under_test)


def executive_killed(under_test: Bench) -> None:
    """Kill the executive; nothing may be left of the robot."""
    mover = under_test.drive()
    fault_ns = under_test.kill(under_test.robot.popen.pid)
    zero = under_test.stopped_after("S6", fault_ns)
    left = wait_until_gone(under_test, fault_ns, HANG_S)
    if left:
        under_test.results.check("S6 gone", [f"still there after {HANG_S:g} s: {', '.join(left)}"])
    else:
        under_test.results.sample("S6 gone", (time.monotonic_ns() - fault_ns) * 1e-6)
    mover.cease()
    under_test.stays_at_rest(zero)
    under_test.robot.popen.wait(HANG_S)


def wait_until_gone(under_test: Bench, fault_ns: int, limit_s: float) -> list[str]:
    """Wait until no process of the robot is left; return the command lines of those that are."""
    end_ns = fault_ns + int(limit_s * 1e9)
    while True:
        left = processes_of(under_test.robot.home)
        if not left or time.monotonic_ns() > end_ns:
            return [_named(process) for process in left]
        under_test.pass_time(0.02)


def _named(process: psutil.Process) -> str:
    try:
        return f"{process.pid} {' '.join(process.cmdline()[:4])}"
    except psutil.Error:
        return str(process.pid)
