"""What a whole simulated robot costs: time to ready, CPU while idle, private memory, process by process.

`python -m benchmarks footprint --seconds 20`. Private memory (USS) stands beside as many processes that have a zenoh
session and nothing else. The world and what draws its pictures are listed and left out of the sum: a real robot has
none. The cameras are switched off first, unless `--cameras`. Exit code 1 if a hard value is broken: ready in 3 s.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

from benchmarks import Measured
from lbr.bus.session import leaf_environment
from tests.support import programs
from tests.support.bench import Bench, let_go, processes_of, temporary_home
from tests.support.clients import idle
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, start

SMOKE = "--seconds 1"

PROMISES = {"ready": Promise(what="`lbr run` to ready, database made", unit="s", hard=3.0)}
SIMULATION = "world"


def options(parser: argparse.ArgumentParser) -> None:
    """Add how long, and of what."""
    parser.add_argument("--seconds", type=float, default=20.0, help="how long it is idle (default %(default)s)")
    parser.add_argument("--cameras", action="store_true", help="leave the cameras as they come")


def measure(given: argparse.Namespace) -> Measured:
    """Run a whole robot, idle."""
    results = Results(PROMISES)
    with temporary_home() as home:
        (home / "robot.db").unlink()
        began = time.monotonic()
        robot = start(home)
        results.sample("ready", time.monotonic() - began)
        try:
            if not given.cameras:
                robot.line("/camera/off")
            costs = _costs(robot, given.seconds)
        finally:
            let_go(robot)
    with _bare(len(costs)) as bare:
        Bench.pass_time(1.0)
        bare_mib = [_private_mib(process) for process in bare]
    return Measured(results=results.ordered(), load=f"idle for {given.seconds:g} s", text=_text(costs, bare_mib))


def _costs(robot: Robot, seconds: float) -> dict[str, tuple[float, float]]:
    """Return CPU in percent of one core and private MiB by process."""
    Bench.pass_time(2.0)
    names = _names(robot)
    before = {pid: _cpu_s(psutil.Process(pid)) for pid in names}
    began = time.monotonic()
    Bench.pass_time(seconds)
    spent_s = time.monotonic() - began
    return {
        name: ((_cpu_s(psutil.Process(pid)) - before[pid]) / spent_s * 100, _private_mib(psutil.Process(pid)))
        for pid, name in names.items()
    }


def _names(robot: Robot) -> dict[int, str]:
    units = {unit["pid"]: unit["name"] for unit in robot.line("/report/health")["data"]["capabilities"]}
    names = {robot.popen.pid: "executive (with the router)"} | units
    for process in processes_of(robot.home):
        names.setdefault(process.pid, f"child of {names.get(process.ppid(), process.ppid())}")
    return names


def _text(costs: dict[str, tuple[float, float]], bare_mib: list[float]) -> str:
    text = ["", "| process | CPU, % of a core | private memory, MiB |", "|---|--:|--:|"]
    text += [f"| {name} | {cpu:.1f} | {memory:.1f} |" for name, (cpu, memory) in costs.items()]
    counted = [cost for name, cost in costs.items() if name not in {SIMULATION, f"child of {SIMULATION}"}]
    cpu, memory = sum(cost[0] for cost in counted), sum(cost[1] for cost in counted)
    bare = sum(bare_mib[: len(counted)])
    text += [
        f"| all but the simulation | {cpu:.1f} | {memory:.1f} |",
        f"| {len(counted)} processes with a bare zenoh session | | {bare:.1f} |",
        f"\nratio of memory: {memory / bare:.2f}",
    ]
    return "\n".join(text)


@contextmanager
def _bare(count: int) -> Iterator[list[psutil.Process]]:
    """Run a bare router and clients of it, `count` processes in all."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        endpoint = f"unixsock-stream/{Path(place) / 'bare.sock'}"
        popens = [_idle("router", endpoint)]
        try:
            popens += [_idle("client", endpoint) for _ in range(count - 1)]
            yield [psutil.Process(popen.pid) for popen in popens]
        finally:
            for popen in reversed(popens):
                popen.communicate()


def _idle(mode: str, endpoint: str) -> "subprocess.Popen[str]":
    popen = programs.start(
        [sys.executable, idle.__file__, mode, endpoint],
        env=leaf_environment() if mode == "client" else None,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert popen.stdout is not None
    if popen.stdout.readline().strip() != "ready":
        raise AssertionError(f"the bare {mode} did not start")
    return popen


def _cpu_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _private_mib(process: psutil.Process) -> float:
    return float(process.memory_full_info().uss) / 2**20
