"""P3: random signals to random processes while three people use the robot; afterwards everything is as before."""

import random
import signal
import sqlite3
import time
from contextlib import suppress
from typing import NamedTuple

import psutil

from lbr.database.store import Database
from tests.scenarios.kills import wait_until_gone
from tests.scenarios.traffic import Traffic
from tests.support.bench import Bench, bench, let_go, processes_of
from tests.support.figures import Results
from tests.support.robot import start

SIGNALS = ("KILL", "STOP", "TERM", "SEGV", "ABRT")
APART_S = (0.2, 1.5)
FROZEN_S = (0.1, 0.8)
LATCHED_EVERY, LATCHED_FOR = 12, 3
READY_S = 15.0
SPARE = {"executive": 1}
"""SQLite keeps the descriptor of a closed connection for the next one while another holds a lock."""
LOOKS, BETWEEN_LOOKS_S = 5, 0.3
IDLE_THREADS_S = 11.0
"""After this long the bus ends threads that have nothing to do."""
WORKERS = {"executive": 20}
"""Threads made when they are first needed, never more than these: 16 for console lines, 4 for stops and resets."""


class Cost(NamedTuple):
    """What a process holds."""

    pid: int
    fds: int
    threads: int
    rss_mib: float


class Storm:
    """Hurts one robot, starts it again when it is gone, and gives failed capabilities another chance, as a person would."""

    def __init__(self, under_test: Bench, dice: random.Random) -> None:
        self.killed_anew = 0
        self._under_test = under_test
        self._dice = dice

    def strike(self) -> str:
        """Send one random signal to one random process; return what and whom."""
        processes = processes_of(self._under_test.robot.home)
        if not processes:
            self.mend()
            return "nobody"
        victim, name = self._dice.choice(processes), self._dice.choice(SIGNALS)
        with suppress(psutil.Error):
            victim.send_signal(getattr(signal, f"SIG{name}"))
            if name == "STOP":
                self._under_test.pass_time(self._dice.uniform(*FROZEN_S))
                victim.send_signal(signal.SIGCONT)
        return f"{name} to {victim.pid}"

    def mend(self) -> None:
        """Start the robot again if its executive is gone, and what has been given up."""
        under_test = self._under_test
        if under_test.robot.popen.poll() is not None:
            left = wait_until_gone(under_test, time.monotonic_ns(), 3.0)
            under_test.results.check("P3", [f"an orphan: {text}" for text in left])
            let_go(under_test.robot)
            under_test.robot = start(under_test.robot.home)
            self.killed_anew += 1
        with suppress(Exception):
            for unit in under_test.robot.status()["capabilities"]:
                if unit["phase"] in {"failed", "stopped"}:
                    under_test.robot.line(f"/restart/{unit['name']}")

    def calm(self) -> float | None:
        """Strike no more, and wait until all is ready; return the milliseconds that took, None if it never was."""
        began = time.monotonic()
        while time.monotonic() - began < READY_S:
            self.mend()
            if self._all_ready():
                return (time.monotonic() - began) * 1000
            self._under_test.pass_time(0.05)
        return None

    def _all_ready(self) -> bool:
        status = None
        with suppress(Exception):
            status = self._under_test.robot.ask("@status", timeout_s=0.5)
        return status is not None and all(unit["phase"] == "ready" for unit in status["capabilities"])


def storm(results: Results, n: int, seed: int = 1) -> None:
    """P3, with `n` signals."""
    with bench(results) as under_test:
        under_test.all_ready()
        before = _least(under_test)
        traffic = Traffic(under_test.robot, seed)
        traffic.start()
        try:
            _rage(under_test, Storm(under_test, random.Random(seed)), n)
        finally:
            traffic.end()
        under_test.pass_time(IDLE_THREADS_S)
        after = _least(under_test)
        results.check("P3", [*traffic.lost(), *left_over(under_test), *audit_faults(under_test)])
        _grown(results, before, after)


def costs(under_test: Bench) -> dict[str, Cost]:
    """Return what every process of a robot holds, by name."""
    names = {unit["pid"]: unit["name"] for unit in under_test.units()}
    names[under_test.robot.popen.pid] = "executive"
    found = {}
    for process in processes_of(under_test.robot.home):
        with suppress(psutil.Error):  # it may end at any moment
            name = names.get(process.pid) or f"child of {names.get(process.ppid(), '?')}"
            found[name] = Cost(process.pid, process.num_fds(), process.num_threads(), process.memory_info().rss / 2**20)
    return found


def _least(under_test: Bench) -> dict[str, Cost]:
    """Return what every process holds at least over a while; now and then one more is open for a moment."""
    found = costs(under_test)
    for _ in range(LOOKS):
        under_test.pass_time(BETWEEN_LOOKS_S)
        for name, cost in costs(under_test).items():
            old = found.get(name, cost)
            least = (min(pair) for pair in zip(cost[1:], old[1:], strict=True))
            found[name] = Cost(cost.pid, *least)
    return found


def _rage(under_test: Bench, storm: Storm, n: int) -> None:
    dice = random.Random(n)
    for turn in range(n):
        storm.strike()
        storm.mend()
        if turn % LATCHED_EVERY == LATCHED_EVERY - 1:
            _latched(under_test, storm)
        under_test.pass_time(dice.uniform(*APART_S))
    ready_ms = storm.calm()
    if ready_ms is None:
        under_test.results.check("P3", [f"not all is ready after {READY_S:g} s: {under_test.state()}"])
    else:
        under_test.results.sample("P3 ready", ready_ms)


def _latched(under_test: Bench, storm: Storm) -> None:
    """Latch for a few strikes more: nothing may turn once every device has stopped, until the reset."""
    storm.calm()
    under_test.robot.line("estop")
    _acknowledged(under_test)
    since_ns = time.monotonic_ns()
    for _ in range(LATCHED_FOR):
        storm.strike()
    storm.calm()
    state = under_test.answer("@estop")
    under_test.trace.read()
    moved = [entry for entry in under_test.trace.outputs(since_ns) if not entry.zero]
    wrong = [f"a disarmed robot moved: {moved[0]}"] if moved else []
    wrong += [] if state["engaged"] else ["the latch is gone"]
    under_test.results.check("P3", wrong)

    def released() -> bool:
        storm.mend()  # the last strike may have told the executive to end, which it does in its own time
        return _reset(under_test)

    under_test.until(released, 12.0, "the emergency stop reset", every_s=0.1)


def _acknowledged(under_test: Bench) -> None:
    def stands() -> bool:
        state = under_test.robot.ask("@estop")
        return bool(state and state["engaged"] and not state["waiting"])

    under_test.until(stands, 6.0, "the emergency stop acknowledged", every_s=0.02)


def _reset(under_test: Bench) -> bool:
    answer = under_test.robot.ask("@estop/reset", {}, timeout_s=3.0)
    return answer is not None and bool(answer["accepted"])


def left_over(under_test: Bench) -> list[str]:
    """Return zombies, and processes that belong to nobody; what a dead fork server had forked belongs to the executive."""
    executive = psutil.Process(under_test.robot.popen.pid)
    family = executive.children(recursive=True)
    for unit in under_test.units():
        with suppress(psutil.Error):
            process = psutil.Process(unit["pid"])
            family += [process, *process.children(recursive=True)]
    zombies = [f"zombie {child.pid}" for child in family if child.status() == psutil.STATUS_ZOMBIE]
    known = {executive.pid, *(child.pid for child in family)}
    orphans = [process for process in processes_of(under_test.robot.home) if process.pid not in known]
    return [*zombies, *(f"orphan {process.pid} {process.cmdline()[:4]}" for process in orphans)]


def audit_faults(under_test: Bench) -> list[str]:
    """Return what is wrong with audit trail and database."""
    with Database.open(under_test.robot.home / "robot.db") as database:
        fault = database.audit_fault()
    with sqlite3.connect(under_test.robot.home / "robot.db") as plain:
        sound = plain.execute("PRAGMA integrity_check").fetchone()[0]
    plain.close()
    return [*([f"audit trail: {fault}"] if fault else []), *([] if sound == "ok" else [f"database: {sound}"])]


def _grown(results: Results, before: dict[str, Cost], after: dict[str, Cost]) -> None:
    results.check("P3", [f"{name} is gone" for name in before if name not in after])
    for name in before.keys() & after.keys():
        old, new = before[name], after[name]
        more = new.fds > old.fds + SPARE.get(name, 0)
        results.check("P3", [f"{name}: {old.fds} descriptors became {new.fds}"] if more else [])
        more = new.threads > old.threads + WORKERS.get(name, 0)
        results.check("P3", [f"{name}: {old.threads} threads became {new.threads}"] if more else [])
        results.sample("P3 memory", (new.rss_mib / old.rss_mib - 1) * 100)
