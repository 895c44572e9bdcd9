"""Whole robots, as they ship, of whose processes some are frozen when the executive is killed: nothing may be left."""

import os
import random
import signal
import sqlite3
import tempfile
import time
from contextlib import closing, suppress
from pathlib import Path

import psutil

from lbr.database import store
from tests.support.bench import Bench, let_go, processes_of
from tests.support.figures import Results
from tests.support.robot import prepare, start

LEFT_S = 2.0
STOP_S = 0.5
HUMANOIDS = ("bioloid-sim", "uxa90-sim")


def anything_frozen(results: Results, n: int, *, dice: random.Random | None = None) -> None:
    """S6 frozen: one process, some, or all but the executive; four robots of five drive, or have torque."""
    dice = dice or random.Random()
    for turn in range(n):
        profile = dice.choice(HUMANOIDS) if turn % 5 == 4 else "lbr-sim"
        with tempfile.TemporaryDirectory(prefix="lbr-") as place:
            killed_with_frozen(results, _whole(Path(place) / "h"), profile, dice)


def killed_with_frozen(results: Results, home: Path, profile: str, dice: random.Random) -> None:
    """Run a robot, freeze some of it, kill its executive, and look what is left."""
    under_test = Bench(start(home, profile=profile), results, dice=dice)
    family: list[psutil.Process] = []
    try:
        mover = under_test.drive() if profile == "lbr-sim" and dice.random() < 0.8 else None
        if profile in HUMANOIDS and dice.random() < 0.8:
            under_test.robot.line("/torque/on")
        executive = psutil.Process(under_test.robot.popen.pid)
        family = sorted(
            {*executive.children(recursive=True), *processes_of(home)} - {executive}, key=lambda one: one.pid
        )
        frozen = dice.sample(family, dice.choice((1, 1, 1, 2, 5, len(family))))
        with_it = f"; frozen: {', '.join(map(_named, frozen))}"
        for process in frozen:
            process.send_signal(signal.SIGSTOP)
        under_test.pass_time(dice.choice((0.0, 0.0, 0.05, 0.3)))
        fault_ns = under_test.kill(executive.pid)
        zero = under_test.stopped_after("S6 frozen stop", fault_ns, limit_s=STOP_S, with_it=with_it) if mover else None
        left = _left(under_test, family, fault_ns)
        if left:
            results.check("S6 frozen", [f"{profile}: still there after {LEFT_S:g} s: {', '.join(left)}{with_it}"])
        else:
            results.sample("S6 frozen", (time.monotonic_ns() - fault_ns) * 1e-6)
        if mover:
            mover.cease()
            under_test.stays_at_rest(zero)
    finally:
        for process in family:
            with suppress(psutil.Error):
                process.send_signal(signal.SIGCONT)
        let_go(under_test.robot)


def _whole(home: Path) -> Path:
    """Make a home whose robots run as they ship, but for the trace of the motors and the ports."""
    with tempfile.TemporaryDirectory() as place:
        shipped = Path(place) / "robot.db"
        store.create(shipped)
        with closing(sqlite3.connect(shipped)) as database:
            names = [
                name for (name,) in database.execute("SELECT name FROM capability WHERE robot = 'lbr' AND enabled")
            ]
    return prepare(home, *names)


def _left(under_test: Bench, family: list[psutil.Process], fault_ns: int) -> list[str]:
    """Wait until no process of the family is left, nor any in its home; return those that are after the time."""
    while True:
        found = {*filter(_lives, family), *processes_of(under_test.robot.home)}
        found -= {psutil.Process(os.getpid())}
        under_test.robot.popen.poll()
        if not found or time.monotonic_ns() - fault_ns > LEFT_S * 1e9:
            return sorted(map(_named, found))
        under_test.pass_time(0.02)


def _lives(process: psutil.Process) -> bool:
    with suppress(psutil.Error):
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    return False


def _named(process: psutil.Process) -> str:
    with suppress(psutil.Error):
        return f"{process.pid} {' '.join(process.cmdline()[-3:])[:80]}"
    return str(process.pid)
