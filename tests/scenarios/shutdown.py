"""P4: shutting down, in every way there is, while the robot drives."""

import os
import signal
import sqlite3
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import msgspec
import psutil

from lbr import home as homes
from tests.support import programs
from tests.support.bench import Bench, let_go, processes_of, temporary_home
from tests.support.figures import Results
from tests.support.robot import LBR, Robot, environment, start
from tests.support.waiting import until

GONE_HARD_MS, GONE_FROZEN_HARD_MS = 3000.0, 5000.0
FIRST, LAST = "drive", "world"


def by_word(under_test: Bench) -> None:
    """The word `Shutdown` at a console."""
    said = under_test.robot.line("Shutdown")
    assert said["code"] == 0, said


def by_signal(number: int) -> Callable[[Bench], None]:
    """A signal to the executive."""
    return lambda under_test: os.kill(under_test.robot.popen.pid, number)


def by_end_of_input(under_test: Bench) -> None:
    """The end of the console's input."""
    assert under_test.robot.popen.stdin is not None
    under_test.robot.popen.stdin.close()


WAYS: dict[str, Callable[[Bench], None]] = {
    "Shutdown": by_word,
    "SIGTERM": by_signal(signal.SIGTERM),
    "SIGINT": by_signal(signal.SIGINT),
    "SIGHUP": by_signal(signal.SIGHUP),
    "end of input": by_end_of_input,
}


def shut_down(results: Results, how: str, *, freeze: str = "") -> None:
    """Shut a driving robot down, perhaps with one process that no longer answers."""
    with temporary_home(whole=results.whole) as home:
        robot = _with_console(home) if how == "end of input" else start(home)
        under_test = Bench(robot, results)
        try:
            mover = under_test.drive()
            if freeze:
                os.kill(under_test.pid(freeze), signal.SIGSTOP)
            at_ns = time.monotonic_ns()
            WAYS[how](under_test)
            zero = under_test.stopped_after("P4 stop", at_ns)
            code = robot.popen.wait(8.0)
            gone_ms = (time.monotonic_ns() - at_ns) * 1e-6
            mover.cease()
            results.sample("P4 gone, one frozen" if freeze else "P4 gone", gone_ms)
            results.check("P4", _wrong(home, code, how, freeze))
            under_test.stays_at_rest(zero)
            under_test.check_limits()
        finally:
            let_go(robot)


def shutdowns(results: Results, n: int) -> None:
    """P4, all ways in turn, and with a frozen process."""
    for _ in range(n):
        for how in WAYS:
            shut_down(results, how)
        shut_down(results, "SIGTERM", freeze="ranges")


def _wrong(home: Path, code: int, how: str, freeze: str) -> list[str]:
    found = [] if code == 0 else [f"{how}: exit code {code}"]
    left = processes_of(home)
    found += [f"{how}: {_name(process)} is left" for process in left]
    with sqlite3.connect(home / "robot.db") as database:
        rows = database.execute(
            "SELECT subject FROM event WHERE kind = 'stopped' AND text = 'stopped' ORDER BY id"
        ).fetchall()
    database.close()
    order = [subject for (subject,) in rows]
    drivers = [name for name in ("motors", "ranges") if name in order]
    if not freeze and not (order and order[-1] == LAST and set(order[:2]) == {FIRST, "motors"} and len(drivers) == 2):
        found.append(f"{how}: the order was {', '.join(order) or 'not recorded'}")
    return found


def _name(process: psutil.Process) -> str:
    with suppress(psutil.Error):
        return f"{process.pid} {' '.join(process.cmdline()[:4])}"
    return str(process.pid)


def _with_console(home: Path) -> Robot:
    """Run a robot whose console reads from a pipe."""
    with (home / "stderr.txt").open("ab") as errors:
        popen = programs.start(
            [*LBR, "run", "lbr-sim"],
            env=environment(home),
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            text=True,
        )
    record = home / "run" / "lbr.json"
    until(record.exists, what="the running robot's record")
    found = msgspec.json.decode(record.read_bytes(), type=homes.Running)
    robot = Robot(home, popen, {"robot": found.robot, "endpoints": list(found.endpoints)})
    until(lambda: (robot.ask("@status") or {}).get("ready"), what="ready")
    return robot
