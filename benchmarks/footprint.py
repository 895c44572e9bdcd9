"""The cost of a whole simulated robot: time to ready, CPU and wake-ups while idle, private memory, process by process.

`python -m benchmarks footprint --seconds 20 --profile bioloid-sim`. Private memory (USS) is compared with as many
processes that have only a zenoh session. The sum leaves out the world and its drawing process, which a real robot does
not have. The cameras are switched off first, unless `--cameras`. A humanoid stands with `--say /torque/on --settle 5`.
`--driving` leaves them on, opens the page in a browser, whose own cost is left out, and drives circles at 0.3 m/s. A
wake-up is counted whenever a thread slept and was woken. Exit code 1 if a hard value is broken: ready in 3 s.
"""

import argparse
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, nullcontext, suppress
from pathlib import Path
from typing import NamedTuple

import psutil

from benchmarks import Measured
from benchmarks.instruments.browsers import browsers
from lbr.bus.session import leaf_environment
from lbr.database import store
from tests.support import programs
from tests.support.bench import Bench, let_go, processes_of, temporary_home
from tests.support.clients import idle
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, start

SMOKE = "--seconds 1"

PROMISES = {"ready": Promise(what="`lbr run` to ready, database made", unit="s", hard=3.0)}
SIMULATION = "world"
CIRCLE = {"vx_mps": 0.3, "vy_mps": 0.0, "wz_rps": 0.8}
RENEW_S = 0.1
LEAST_MPS = 0.2
"""The least mean speed, with the start of the motion in it, of a robot that was not stopped on its way."""


class Cost(NamedTuple):
    """The cost of a process."""

    cpu_percent: float
    wakes_per_s: float
    private_mib: float

    def row(self, name: str) -> str:
        """Return it as a row of a table."""
        return f"| {name} | {self.cpu_percent:.1f} | {self.wakes_per_s:.0f} | {self.private_mib:.1f} |"


def _sum(costs: Sequence[Cost]) -> Cost:
    return Cost(*(sum(values) for values in zip(*costs, strict=True)))


def options(parser: argparse.ArgumentParser) -> None:
    """Add the duration, and the robot."""
    parser.add_argument("--seconds", type=float, default=20.0, help="how long it is idle (default %(default)s)")
    parser.add_argument("--profile", default="lbr-sim", help="which robot (default %(default)s)")
    parser.add_argument("--say", action="append", default=[], help="a line said to it first, such as /torque/on")
    parser.add_argument("--settle", type=float, default=2.0, help="seconds until it is at rest (default %(default)s)")
    parser.add_argument("--apart", action="store_true", help="give each capability a process of its own")
    parser.add_argument("--cameras", action="store_true", help="leave the cameras as they come")
    parser.add_argument("--driving", action="store_true", help="drive circles, with cameras and a page that looks")


def measure(given: argparse.Namespace) -> Measured:
    """Run a whole robot, idle."""
    results = Results(PROMISES)
    with temporary_home() as home:
        (home / "robot.db").unlink()
        if given.apart:
            _apart(home / "robot.db")
        began = time.monotonic()
        robot = start(home, profile=given.profile)
        results.sample("ready", time.monotonic() - began)
        try:
            if not (given.cameras or given.driving):
                robot.line("/camera/off")
            for line in given.say:
                robot.line(line)
            with _drives(robot, home) if given.driving else nullcontext():
                costs = _costs(robot, given.seconds, given.settle)
        finally:
            let_go(robot)
    with _bare(len(costs)) as bare:
        Bench.pass_time(1.0)
        bare_mib = [_private_mib(process) for process in bare]
    return Measured(
        results=results.ordered(),
        load=f"{'driving' if given.driving else 'idle'} for {given.seconds:g} s",
        text=_text(costs, bare_mib),
    )


@contextmanager
def _drives(robot: Robot, folder: Path) -> Iterator[None]:
    """Drive circles for the time of a `with`, while a browser shows the page; a robot that stands is an error."""
    over = threading.Event()

    def circle() -> None:
        lease = ""
        while not over.wait(RENEW_S):
            answer = robot.ask("drive/twist", CIRCLE | {"lease": lease})
            lease = (answer or {}).get("lease", "")

    with browsers(folder) as opened:
        opened.open().look(robot.line("pair")["data"]["url"])
        driver = threading.Thread(target=circle)
        driver.start()
        began = time.monotonic()
        try:
            yield
            mean_mps = (robot.ask("odometry/state") or {})["distance_m"] / (time.monotonic() - began)
            assert mean_mps > LEAST_MPS, f"it drove at {mean_mps:.2f} m/s only"
        finally:
            over.set()
            driver.join()
            robot.line("stop")


def _apart(database: Path) -> None:
    """Make a database whose capabilities share no process."""
    store.create(database)
    with closing(sqlite3.connect(database)) as rows, rows:
        rows.execute("UPDATE capability SET process = ''")


def _costs(robot: Robot, seconds: float, settle_s: float) -> dict[str, Cost]:
    """Return the cost of each idle process that is there until the end: a speech engine without a text is ended."""
    Bench.pass_time(settle_s)
    names = _names(robot)
    before = {pid: (_cpu_s(psutil.Process(pid)), _woken(pid)) for pid in names}
    began = time.monotonic()
    Bench.pass_time(seconds)
    spent_s = time.monotonic() - began
    return {
        name: Cost(
            cpu_percent=(_cpu_s(psutil.Process(pid)) - before[pid][0]) / spent_s * 100,
            wakes_per_s=sum(n - before[pid][1].get(thread, n) for thread, n in _woken(pid).items()) / spent_s,
            private_mib=_private_mib(psutil.Process(pid)),
        )
        for pid, name in names.items()
        if psutil.pid_exists(pid)
    }


def _woken(pid: int) -> dict[str, int]:
    """Return how often each thread of a process has slept by itself."""
    found = {}
    for status in Path(f"/proc/{pid}/task").glob("*/status"):
        with suppress(OSError):  # it has ended meanwhile
            found[status.parent.name] = int(status.read_text().rpartition("\nvoluntary_ctxt_switches:")[2].split()[0])
    return found


def _names(robot: Robot) -> dict[int, str]:
    units = {
        unit["pid"]: unit["process"] or unit["name"] for unit in robot.line("/report/health")["data"]["capabilities"]
    }
    names = {robot.popen.pid: "executive (with the router)"} | units
    for process in processes_of(robot.home):
        child = f"child of {names.get(process.ppid(), process.ppid())}"
        names.setdefault(process.pid, f"another {child}" if child in names.values() else child)
    return names


def _text(costs: dict[str, Cost], bare_mib: list[float]) -> str:
    text = ["", "| process | CPU, % of a core | wake-ups a second | private memory, MiB |", "|---|--:|--:|--:|"]
    text += [cost.row(name) for name, cost in costs.items()]
    counted = [cost for name, cost in costs.items() if name not in {SIMULATION, f"child of {SIMULATION}"}]
    whole, bare = _sum(counted), sum(bare_mib[: len(counted)])
    text += [
        whole.row("all but the simulation"),
        _sum(list(costs.values())).row("all"),
        f"| {len(counted)} processes with a bare zenoh session | | | {bare:.1f} |",
        f"\nratio of memory: {whole.private_mib / bare:.2f}",
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
