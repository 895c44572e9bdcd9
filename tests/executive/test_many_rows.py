"""However many rows come at once, the robot hears who stops it, and what an edit has cost is free once it is undone."""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from tests.support.robot import Robot, running
from tests.support.waiting import HANG_S, STOPS_S, until

QUIET = """
from lbr.capability import Capability, Kind, NoSettings

class Quiet(Capability[NoSettings]):
    def step(self) -> None:
        pass

KIND = Kind(name="quiet", summary="does nothing", family="app", entry=Quiet)
"""


@pytest.fixture(scope="module")
def robot(shared_home: Path) -> Iterator[Robot]:
    (shared_home / "capabilities").mkdir(mode=0o700)
    (shared_home / "capabilities" / "quiet.py").write_text(QUIET)
    with running(shared_home) as started:
        yield started


def add(robot: Robot, count: int) -> None:
    rows = f"WITH RECURSIVE n(i) AS (VALUES(0) UNION ALL SELECT i + 1 FROM n WHERE i < {count - 1}) "
    robot.edit(f"{rows} INSERT INTO capability (robot, name, kind) SELECT 'lbr', 'quiet' || i, 'quiet' FROM n")


def hears(robot: Robot) -> None:
    """Say a stop and ask for the status; both are answered in time."""
    for line in ("s", "/report/health"):
        begun = time.monotonic()
        assert robot.line(line)["code"] == 0
        assert time.monotonic() - begun < STOPS_S


def test_more_rows_than_there_is_room_for_start_nothing_and_cost_no_stop(robot: Robot) -> None:
    before = {unit["name"]: unit["pid"] for unit in robot.status()["capabilities"]}
    add(robot, 300)
    until(lambda: [hears(robot), robot.status()["problems"]][1])
    assert "303 processes would run, but" in robot.status()["problems"][0]
    assert {unit["name"]: unit["pid"] for unit in robot.status()["capabilities"]} == before
    robot.press()
    robot.edit("DELETE FROM capability WHERE kind = 'quiet'")
    until(lambda: not robot.status()["problems"])


def test_a_dozen_rows_at_once_come_in_by_one_router_and_leave_nothing_behind(robot: Robot) -> None:
    executive = psutil.Process(robot.ready["pid"])
    before = None
    for _ in range(3):
        add(robot, 12)
        until(lambda: [hears(robot), up(robot) == 12][1])
        assert len(list((robot.home / "run").glob("lbr.[0-9]*.sock"))) == 1
        robot.edit("DELETE FROM capability WHERE kind = 'quiet'")
        until(lambda: [hears(robot), up(robot) == 0][1])
        until(lambda: not list((robot.home / "run").glob("lbr.[0-9]*")))
        before = before or executive.num_fds()  # the first edit has files of the database opened, once for all
    until(lambda: executive.num_fds() <= before)


def test_sigterm_ends_it_while_rows_begin(robot: Robot) -> None:
    """The last one here: it ends the robot."""
    add(robot, 40)
    until(lambda: up(robot, "starting") > 0)
    os.kill(robot.ready["pid"], signal.SIGTERM)
    assert robot.popen.wait(HANG_S) == 0


def up(robot: Robot, phase: str = "ready") -> int:
    return sum(unit["kind"] == "quiet" and unit["phase"] == phase for unit in robot.status()["capabilities"])
