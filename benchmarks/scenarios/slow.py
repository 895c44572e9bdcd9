"""B3 and B4: listeners that are stopped or slow cost nobody anything; what the robot costs at rest."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import psutil

from benchmarks.bench import Bench, bench, processes_of
from benchmarks.clients import listener
from benchmarks.figures import Results, percentile
from benchmarks.scenarios import estop
from tests.robot import Robot

FROZEN, SLOW = 5, 5
PRESSES = 5
SETTLE_S = 2.0
LISTEN_S = 8.0
SIMULATION = "world"


def slow_listeners(results: Results, n: int) -> None:
    """B3, `n` times: ten listeners to everything, half of them frozen, half taking one message a second."""
    for _ in range(n):
        with bench(results) as under_test:
            _listened_to(under_test)


def at_rest(results: Results, n: int) -> None:
    """B4, for `n` seconds; the simulation is left out of the CPU, a real robot has none."""
    with bench(results) as under_test:
        under_test.pass_time(SETTLE_S)
        processes = processes_of(under_test.robot.home)
        counted = [process for process in processes if process.pid != under_test.pid(SIMULATION)]
        before = _cpu_s(counted)
        under_test.pass_time(float(n))
        results.sample("B4 CPU", (_cpu_s(counted) - before) / n * 100)
        results.sample("B4", sum(process.memory_info().rss for process in processes) / 2**20)


def memory_mib(robot: Robot) -> dict[int, float]:
    """Return the resident memory of every process of a robot."""
    found = {}
    for process in processes_of(robot.home):
        with suppress(psutil.Error):
            found[process.pid] = process.memory_info().rss / 2**20
    return found


def _listened_to(under_test: Bench) -> None:
    quiet_ms = _press_many(under_test)
    before = memory_mib(under_test.robot)
    with _listeners(under_test.robot):
        mover = under_test.drive()
        under_test.pass_time(LISTEN_S)
        mover.cease()
        under_test.until(lambda: under_test.trace.now().zero, 2.0, "rest")
        heard_ms = _press_many(under_test)
        after = memory_mib(under_test.robot)
    results = under_test.results
    results.sample("B3 ratio", heard_ms / quiet_ms)
    results.sample("B3 memory", max(after[pid] - before[pid] for pid in before if pid in after))
    results.check("B3", [] if set(before) <= set(after) else ["a process ended under slow listeners"])


def _press_many(under_test: Bench) -> float:
    """Press a few times; return the median time to motor zero."""
    figure = under_test.results.of("B3 stop")
    before = len(figure.samples)
    for _ in range(PRESSES):
        estop.press(under_test, "B3 stop", lambda: under_test.robot.line("estop"))
    return percentile(figure.samples[before:], "p50")


@contextmanager
def _listeners(robot: Robot) -> Iterator[None]:
    program = [sys.executable, listener.__file__, robot.endpoints[0], robot.name]
    popens = [
        subprocess.Popen([*program, str(0.0 if n < FROZEN else 1.0)], stdout=subprocess.PIPE, text=True)
        for n in range(FROZEN + SLOW)
    ]
    try:
        for n, popen in enumerate(popens):
            assert popen.stdout is not None
            assert popen.stdout.readline().strip() == "listening"
            if n < FROZEN:
                os.kill(popen.pid, signal.SIGSTOP)
        yield
    finally:
        for popen in popens:
            popen.kill()
            popen.communicate()


def _cpu_s(processes: list[psutil.Process]) -> float:
    times = [process.cpu_times() for process in processes]
    return float(sum(spent.user + spent.system for spent in times))
