"""B3 and B4: listeners that are stopped or slow cost nobody anything; what whole robots cost at rest."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import psutil

from tests.scenarios import estop
from tests.support import programs
from tests.support.bench import Bench, bench, let_go, processes_of, temporary_home
from tests.support.clients import listener
from tests.support.figures import Results, percentile
from tests.support.robot import Robot, start

FROZEN, SLOW = 5, 5
PRESSES = 5
SETTLE_S = 4.0
LISTEN_S = 8.0
SIMULATION = "world"
ROBOTS = ("lbr", "bioloid", "uxa90")


def slow_listeners(results: Results, n: int) -> None:
    """B3, `n` times: ten listeners to everything, half of them frozen, half taking one message a second."""
    for _ in range(n):
        with bench(results) as under_test:
            _listened_to(under_test)


def at_rest(results: Results, n: int) -> None:
    """B4, each robot as it ships for `n` seconds; what it costs without its simulation too, for a real robot has none."""
    for name in ROBOTS:
        with temporary_home(whole=True) as home:
            robot = start(home, profile=f"{name}-sim")
            try:
                _at_rest(results, robot, n)
            finally:
                let_go(robot)


def _at_rest(results: Results, robot: Robot, seconds: int) -> None:
    Bench.pass_time(SETTLE_S)
    processes = processes_of(robot.home)
    world = psutil.Process(robot.capability(SIMULATION)["pid"])
    simulation = {world.pid, *(process.pid for process in world.children(recursive=True))}
    before, began = [_cpu_s(process) for process in processes], time.monotonic()
    Bench.pass_time(float(seconds))
    spent_s = time.monotonic() - began
    cpu = {
        process.pid: (_cpu_s(process) - cpu_s) / spent_s * 100 for process, cpu_s in zip(processes, before, strict=True)
    }
    memory = {process.pid: process.memory_full_info() for process in processes}
    figure = f"B4 {robot.name}"
    results.sample(figure, sum(each.pss for each in memory.values()) / 2**20)
    results.sample(f"{figure} private", sum(each.uss for each in memory.values()) / 2**20)
    results.sample(f"{figure} RSS", sum(each.rss for each in memory.values()) / 2**20)
    results.sample(f"{figure} real", sum(each.pss for pid, each in memory.items() if pid not in simulation) / 2**20)
    results.sample(f"{figure} CPU", sum(each for pid, each in cpu.items() if pid not in simulation))
    results.sample(f"{figure} CPU all", sum(cpu.values()))
    results.sample(f"{figure} processes", len(processes))


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
        programs.start([*program, str(0.0 if n < FROZEN else 1.0)], stdout=subprocess.PIPE, text=True)
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


def _cpu_s(process: psutil.Process) -> float:
    spent = process.cpu_times()
    return float(spent.user + spent.system)
