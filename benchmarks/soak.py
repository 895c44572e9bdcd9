"""Runs a robot for a while: three people use it, and once a minute something breaks; it must not leak, crash or stop
without reason.

`python -m benchmarks soak --minutes 30 --json FILE`; `--seed` makes the same faults in the same order, `--base` only
runs motors, ranges, drive and world. Events go to standard error, and every few minutes the memory of the executive.
Exit code 1 if a hard value is broken.
"""

import argparse
import os
import random
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from statistics import median

from msgspec import structs

from benchmarks import Measured
from tests.scenarios.devices import MOTORS, RANGES, fault
from tests.scenarios.freezes import break_links
from tests.scenarios.storms import WORKERS, Cost, audit_faults, costs, left_over
from tests.scenarios.traffic import Traffic
from tests.support.bench import Bench, bench
from tests.support.figures import BASE, Promise, Results, slope

SMOKE = "--minutes 0.1 --fault-every 3 --base"

LOOK_S = 5.0
FAULT_S = 1.5
EXPLAINED_S = 8.0
WARM_SHARE, LONG_SHARE = 0.2, 0.3
BAD_ENDS = ("crashed", "hung", "trip", "failed")
EXECUTIVE = "executive"
TOLD_EVERY = 36
BOUND_THEIR_FILES = {"box", "speaker"}
"""The number of looks between two lines about the executive's memory: three minutes."""
LAST_SHARE = 1 / 3
LOG_MIB, WAL_MIB, SLOPE_MIB_H = 16.0, 16.0, 1.0

PROMISES: dict[str, Promise] = {
    name: structs.replace(promise, robot=BASE)
    for name, promise in {
        "K1": Promise(what="soak: no end or trip without a fault, nothing lost, left or leaked; everything ready"),
        "K1 memory": Promise(what="soak: growth of any process's resident memory", unit="MiB/h", target=SLOPE_MIB_H),
        "K1 executive": Promise(
            what="soak: growth of the executive's resident memory in the last third", unit="MiB/h", target=SLOPE_MIB_H
        ),
        "K1 logs": Promise(what="soak: size of all logs", unit="MiB", target=LOG_MIB, hard=4 * LOG_MIB),
        "K1 WAL": Promise(
            what="soak: size of the database's write-ahead log", unit="MiB", target=WAL_MIB, hard=4 * WAL_MIB
        ),
        "K1 files": Promise(
            what="soak: files in the home at the end, more than after the beginning, without those of the black box and the speaker, which both bound",
            unit="",
            target=10,
        ),
        "F6": Promise(what="outputs within the configured maximum and slew, in every scenario"),
    }.items()
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the duration, and the robot."""
    parser.add_argument("--minutes", type=float, default=30.0, help="how long (default %(default)s)")
    parser.add_argument("--fault-every", type=float, default=60.0, metavar="SECONDS", help="default: %(default)s")
    parser.add_argument("--base", action="store_true", help="motors, ranges, drive and world alone")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Run the robot."""
    results = Results(PROMISES, whole=not given.base)
    soak(results, given.minutes, given.seed, fault_every_s=given.fault_every)
    return Measured(
        results=[result for result in results.ordered() if result.figure.startswith("K1") or result.violations],
        load=f"{given.minutes:g} minutes, seed {given.seed}",
        repeated=results.repeated,
        disturbed=results.disturbed,
    )


class Soak:
    """One robot under observation."""

    def __init__(self, under_test: Bench, seed: int) -> None:
        self.looks: list[tuple[float, dict[str, Cost]]] = []
        self.files: list[set[str]] = []
        self._under_test = under_test
        self._results = under_test.results
        self._dice = random.Random(seed)
        self._began = time.monotonic()
        self._excused_until = 0.0
        self._seen_ns = time.time_ns()
        self._faults = self._shuffled()

    def run(self, minutes: float, *, fault_every_s: float = 60.0) -> None:
        """Look every few seconds, break something once a minute."""
        end, next_fault = self._began + minutes * 60, self._began + fault_every_s
        while time.monotonic() < end:
            self._under_test.pass_time(LOOK_S)
            if time.monotonic() >= next_fault:
                next_fault += fault_every_s
                self._break_something()
            self._look()

    def _break_something(self) -> None:
        name, how = next(self._faults)
        print(f"{self._minutes():.1f} min: {name}", file=sys.stderr, flush=True)
        with suppress(AssertionError, OSError, StopIteration):  # the part to break may be gone already
            how()
        self._excused_until = time.monotonic() + EXPLAINED_S

    def _shuffled(self) -> Iterator[tuple[str, Callable[[], None]]]:
        ways = self._ways()
        while True:
            self._dice.shuffle(ways)
            yield from ways

    def _ways(self) -> list[tuple[str, Callable[[], None]]]:
        under_test = self._under_test
        names = sorted(unit["name"] for unit in under_test.units())
        kills = [(f"{name} killed", lambda name=name: self._signal(name, signal.SIGKILL)) for name in names]
        freezes = [(f"{name} frozen", lambda name=name: self._frozen(name)) for name in names]
        faults = [
            (f"{device} {name}", lambda device=device, name=name: self._device(device, name))
            for device, name in ((MOTORS, "unplug"), (MOTORS, "silent"), (RANGES, "unplug"), (RANGES, "silent"))
        ]
        return [
            *kills,
            *freezes,
            *faults,
            ("links broken", lambda: break_links(under_test.robot.popen.pid)),
            ("emergency stop and reset", self._pressed),
        ]

    def _signal(self, name: str, number: int) -> None:
        os.kill(self._under_test.pid(name), number)

    def _frozen(self, name: str) -> None:
        pid = self._under_test.pid(name)
        os.kill(pid, signal.SIGSTOP)
        self._under_test.pass_time(FAULT_S)
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGCONT)

    def _device(self, device: str, name: str) -> None:
        with fault(self._under_test, device, name):
            self._under_test.pass_time(FAULT_S)

    def _pressed(self) -> None:
        self._under_test.robot.line("estop")
        self._under_test.pass_time(FAULT_S)
        self._under_test.robot.ask("@estop/reset", {}, timeout_s=3.0)

    def _look(self) -> None:
        """Note the cost of every process, and each end without a fault."""
        with suppress(AssertionError, StopIteration):  # the robot may not answer while its links are broken
            found = costs(self._under_test)
            self.looks.append((time.monotonic() - self._began, found))
            if len(self.looks) % TOLD_EVERY == 1:
                text = f"{len(found)} processes, the executive has {found[EXECUTIVE].rss_mib:.1f} MiB"
                print(f"{self._minutes():.1f} min: {text}", file=sys.stderr, flush=True)
            events = [event for event in self._under_test.robot.events() if event["wall_ns"] > self._seen_ns]
            self._seen_ns = max((event["wall_ns"] for event in events), default=self._seen_ns)
            bad = [f"{event['subject']}: {event['text']}" for event in events if event["kind"] in BAD_ENDS]
            calm = time.monotonic() > self._excused_until + LOOK_S
            self._results.check("K1", [f"after {self._minutes():.1f} min, {text}" for text in bad] if calm else [])
        home = self._under_test.robot.home
        logs = [path.stat().st_size for path in home.glob("logs/*") if path.is_file()]
        wal = home / "robot.db-wal"
        files = {path.relative_to(home) for path in home.rglob("*")}
        self.files.append({str(path) for path in files if not BOUND_THEIR_FILES & {*path.parts}})
        self._results.sample("K1 logs", sum(logs) / 2**20)
        self._results.sample("K1 WAL", (wal.stat().st_size if wal.exists() else 0) / 2**20)

    def _minutes(self) -> float:
        return (time.monotonic() - self._began) / 60


def soak(results: Results, minutes: float, seed: int, *, fault_every_s: float = 60.0) -> None:
    """K1."""
    with bench(results) as under_test:
        under_test.all_ready()
        traffic = Traffic(under_test.robot, seed)
        life = Soak(under_test, seed)
        traffic.start()
        try:
            life.run(minutes, fault_every_s=fault_every_s)
        finally:
            traffic.end()
        under_test.all_ready(15.0)
        results.check("K1", [*traffic.lost(), *left_over(under_test), *audit_faults(under_test)])
        warm = int(len(life.looks) * WARM_SHARE)
        _leaks(results, life.looks[warm:])
        _levels_off(results, life.looks)
        if added := sorted(life.files[-1] - life.files[warm]):
            print(f"new in the home: {', '.join(added)}", file=sys.stderr, flush=True)
        results.sample("K1 files", max(0, len(life.files[-1]) - len(life.files[warm])))


def _leaks(results: Results, looks: list[tuple[float, dict[str, Cost]]]) -> None:
    """Compare the late part of every long life with the early one: the slope of its memory, and its resources."""
    lives: dict[tuple[str, int], list[tuple[float, Cost]]] = {}
    for at, cost_by_name in looks:
        for name, cost in cost_by_name.items():
            lives.setdefault((name, cost.pid), []).append((at, cost))
    for (name, _), seen in lives.items():
        half = len(seen) // 2
        if len(seen) < len(looks) * LONG_SHARE or half < 2:
            continue
        for what in ("fds", "threads"):
            before = median(getattr(cost, what) for _, cost in seen[:half])
            after = min(getattr(cost, what) for _, cost in seen[half:])
            allowed = WORKERS.get(name, 0) if what == "threads" else 0
            results.check("K1", [f"{name}: {before:g} {what} became {after:g}"] if after > before + allowed else [])
        per_hour = slope([(at / 3600, cost.rss_mib) for at, cost in seen])
        print(f"{name}: {seen[0][1].rss_mib:.1f} to {seen[-1][1].rss_mib:.1f} MiB, {per_hour:.1f}/h", file=sys.stderr)
        results.sample("K1 memory", per_hour)


def _levels_off(results: Results, looks: list[tuple[float, dict[str, Cost]]]) -> None:
    """Return how fast the executive's memory still grows at the end, whatever its first size."""
    points = [(at / 3600, cost[EXECUTIVE].rss_mib) for at, cost in looks if EXECUTIVE in cost]
    last = points[-max(2, int(len(points) * LAST_SHARE)) :]
    print(f"executive: {points[0][1]:.1f} MiB, {last[0][1]:.1f} at two thirds, {last[-1][1]:.1f}", file=sys.stderr)
    results.sample("K1 executive", slope(last))
