"""D4 and E6: a disk that is full, a database that somebody else has locked; the robot drives, stops, says so, recovers."""

import select
import sqlite3
import subprocess
import tempfile
import time
from contextlib import closing, suppress
from pathlib import Path

import psutil

from lbr.database.store import Database
from tests.support import programs
from tests.support.bench import Bench, let_go, prepare, processes_of
from tests.support.figures import Results
from tests.support.robot import LBR, environment, start
from tests.support.small_disk import can_mount, small_disk

SMALL = "6m"
START_S = 4.0
NOT_WRITTEN = "events and the audit trail are not written down"


def full_disk(results: Results) -> None:
    """Fill the disk under a driving robot, stop it, make room, kill it, fill the disk before a start."""
    with small_disk(SMALL) as disk:
        home = _home(disk)
        robot = start(home)
        under_test = Bench(robot, results)
        try:
            _fill(disk)
            _stops_all_the_same(under_test, "E6 full", "the disk is full")
            _recovers(under_test, disk)
        finally:
            let_go(robot)
        _fill(disk)
        _starts_or_says_why(results, home)
        (disk / "filling").unlink()
        _latched_at_start(results, home)


def _recovers(under_test: Bench, disk: Path) -> None:
    """Once there is room, what could not be written is, and nothing is wrong any more."""
    began = time.monotonic()
    (disk / "filling").unlink()
    under_test.until(lambda: not under_test.robot.status()["problems"], 5.0, "no problem any more", every_s=0.02)
    under_test.results.sample("D4 recovered", (time.monotonic() - began) * 1000)
    with Database.open(under_test.robot.home / "robot.db") as database:
        lacks = [] if "estop" in {entry.kind for entry in database.audit()} else ["the press is not in the audit trail"]
        under_test.results.check("D4 full", [*lacks, *filter(None, [database.audit_fault()])])


def locked(results: Results) -> None:
    """Another program locks the database for good: driving and stopping do not care."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        robot = start(prepare(Path(place) / "h"))
        under_test = Bench(robot, results)
        try:
            with closing(sqlite3.connect(robot.home / "robot.db", isolation_level=None)) as other:
                other.execute("BEGIN IMMEDIATE")
                _stops_all_the_same(under_test, "E6 locked", "is locked by another program")
                other.execute("ROLLBACK")
            under_test.until(lambda: not robot.status()["problems"], 5.0, "no problem any more", every_s=0.02)
        finally:
            let_go(robot)
        _latched_at_start(results, robot.home)


def disks(results: Results, n: int) -> None:
    """D4 full, E6."""
    for _ in range(n):
        if can_mount():
            full_disk(results)
        locked(results)


def _stops_all_the_same(under_test: Bench, figure: str, why: str) -> None:
    mover = under_test.drive()
    under_test.until(lambda: _told(under_test, why), 3.0, f"{why} told", every_s=0.02)
    pressed_ns = time.monotonic_ns()
    under_test.robot.put("@estop", {"engaged": True, "reason": figure})
    under_test.stopped_after(figure, pressed_ns)
    mover.cease()
    problems = under_test.robot.status()["problems"]
    events = [event["text"] for event in under_test.robot.events() if event["kind"] == "trouble"]
    differ = [f"@status says {text!r}, no event does" for text in problems if text not in events]
    often = [f"{text!r} told {events.count(text)} times" for text in set(events) if events.count(text) > 1]
    under_test.results.check(figure, [*differ, *often])


def _told(under_test: Bench, why: str) -> bool:
    return any(why in text and text.startswith(NOT_WRITTEN) for text in under_test.robot.status()["problems"])


def _starts_or_says_why(results: Results, home: Path) -> None:
    with programs.start(
        [*LBR, "run", "lbr-sim", "--no-console"],
        env=environment(home),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as popen:
        assert popen.stdout is not None
        answered = select.select([popen.stdout], [], [], START_S)[0]
        said = popen.stdout.readline() if answered else ""
        if not answered or said:
            for process in processes_of(home):
                with suppress(psutil.Error):
                    process.kill()
            results.check("D4 full", [] if '"ready": true' in said else ["a start on a full disk hangs"])
        errors = popen.communicate()[1]
    if answered and not said:
        lines = errors.splitlines()
        good = popen.returncode in (1, 2) and len(lines) == 1 and ("full" in lines[0] or "No space" in lines[0])
        results.check("D4 full", [] if good else [f"a start on a full disk: {popen.returncode} {errors[-800:]!r}"])


def _latched_at_start(results: Results, home: Path) -> None:
    robot = start(home)
    try:
        state = robot.ask("@estop")
        wrong = [] if state["engaged"] else ["after the restart the emergency stop is not latched"]
        reply = robot.ask("drive/command", {"power": 0.4, "angle_deg": 0})
        wrong += ["after the restart it drives"] if reply["accepted"] else []
        results.check("E2", wrong)
    finally:
        let_go(robot)


def _home(disk: Path) -> Path:
    """Make a home on the small disk; what the world traces goes elsewhere."""
    home = prepare(disk / "h")
    (home / "trace.txt").symlink_to(disk.parent / "trace.txt")
    return home


def _fill(disk: Path) -> None:
    with suppress(OSError), (disk / "filling").open("wb", buffering=0) as file:
        for size in (65536, 4096, 1):
            with suppress(OSError):
                while True:
                    file.write(b"x" * size)
