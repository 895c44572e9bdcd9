"""D4 and E2: a database that breaks under a running robot, the start after it, and the way back."""

import os
import signal
from pathlib import Path

from lbr.database import copies
from lbr.database.store import Database
from tests.support.bench import Bench, let_go, temporary_home
from tests.support.figures import Results
from tests.support.robot import lbr, start

BAD_ROWS = 2


def broken_under_a_robot(results: Results) -> None:
    """Cut the file in half while the robot drives: it goes on, stops when told, and says so; then restore."""
    with temporary_home() as home:
        path = home / "robot.db"
        robot = start(home)
        under_test = Bench(robot, results)
        try:
            _keep(path)
            mover = under_test.drive()
            os.truncate(path, path.stat().st_size // 2)
            robot.put("@estop", {"engaged": True, "reason": "broken"})
            under_test.until(lambda: robot.status()["estop"]["engaged"], 2.0, "the latch")
            mover.cease()
            under_test.until(lambda: robot.status()["problems"], 5.0, "the damage told", every_s=0.05)
            told = robot.status()["problems"]
            results.check("D4", [] if any("`lbr db restore`" in text for text in told) else [f"told: {told}"])
            robot.popen.send_signal(signal.SIGKILL)
        finally:
            let_go(robot)
        _refused(results, home)
        _latched_after_restoring(results, home)


def lives(results: Results, n: int) -> None:
    """D4, E2."""
    for _ in range(n):
        broken_under_a_robot(results)


def _keep(path: Path) -> None:
    with Database.open(path) as database:
        digest = database.load("lbr").digest
    copies.keep(path, digest)


def _refused(results: Results, home: Path) -> None:
    done = lbr(home, "run", "lbr-sim", "--no-console")
    lines = done.stderr.splitlines()
    good = done.returncode == BAD_ROWS and len(lines) == 1 and "`lbr db restore`" in lines[0]
    results.check("D4", [] if good else [f"a start with half a database: {done.returncode} {done.stderr[-500:]!r}"])


def _latched_after_restoring(results: Results, home: Path) -> None:
    done = lbr(home, "db", "restore")
    results.check("D4 restore", [] if done.returncode == 0 else [f"restore: {done.stderr!r}"])
    robot = start(home)
    try:
        state = robot.ask("@estop")
        wrong = [] if state["engaged"] and state["reason"] == "broken" else [f"restored, and the latch is {state}"]
        with Database.open(home / "robot.db") as database:
            wrong += filter(None, [database.audit_fault()])
        results.check("E2", wrong)
    finally:
        let_go(robot)
