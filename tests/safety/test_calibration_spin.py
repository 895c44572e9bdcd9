"""A robot that turns on the spot to calibrate its compass: it stands when what turns it is gone, and keeps what it finds."""

import os
import signal
import sqlite3
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.robot import Robot, prepare, running
from tests.support.trace import Trace
from tests.support.waiting import until

pytestmark = [pytest.mark.slow_start]
FASTER = "UPDATE capability SET settings = json_set(settings, '$.spin_power', 0.4) WHERE name = 'attitude'"
LIMIT_S = 15.0
TRIES = 3


@pytest.fixture(scope="module")
def robot() -> Iterator[Robot]:
    """A robot with an inertial unit, that knows how it lies."""
    with (
        tempfile.TemporaryDirectory(prefix="lbr-") as place,
        running(prepare(Path(place) / "h", "imu", "attitude", edits=(FASTER,))) as started,
    ):
        yield started


def progress(robot: Robot) -> dict[str, Any]:
    return robot.ask("attitude/calibration") or {"phase": "none", "text": ""}


def calibrated(robot: Robot) -> set[str]:
    """What the rows know of the inertial unit."""
    database = sqlite3.connect(robot.home / "robot.db")
    names = {name for (name,) in database.execute("SELECT name FROM calibration WHERE device = 'imu'")}
    database.close()
    return names


def spinning(robot: Robot, samples: int) -> Trace:
    """Begin a calibration, and return once the wheels turn; on a busy machine a lease may lapse before, which is told."""
    trace = Trace(robot.trace)
    for _ in range(TRIES):
        until(lambda: robot.line(f"/m/{samples}/-")["code"] == 0, what="a calibration begins")
        until(lambda: trace.now().least > 0.1 or progress(robot)["phase"] == "refused", what="the wheels turn")
        if trace.now().least > 0.1:
            return trace
    raise AssertionError(f"the wheels never turned: {progress(robot)}")


def test_a_calibration_that_is_killed_in_mid_spin_leaves_the_wheels_standing(robot):
    trace = spinning(robot, 2000)
    pid = robot.capability("attitude")["pid"]
    killed_ns = time.monotonic_ns()
    os.kill(pid, signal.SIGKILL)
    zero = trace.first_zero(killed_ns, 2.0)
    assert zero is not None, "the wheels still turn 2 s after the kill"
    until(
        lambda: (unit := robot.capability("attitude"))["pid"] not in {None, pid} and unit["phase"] == "ready",
        what="attitude lives again",
    )
    until(lambda: (robot.ask("attitude/state") or {}).get("valid"), what="it knows how it lies")
    trace.read()
    assert [output for output in trace.outputs(zero.at_ns + 1) if not output.zero] == []
    assert robot.ask("drive/state")["holder"] is None


def test_a_stop_of_the_base_ends_the_calibration(robot):
    trace = spinning(robot, 2000)
    robot.line("s")
    until(lambda: progress(robot)["phase"] == "refused", what="the calibration ends")
    assert "stopped" in progress(robot)["text"]
    assert trace.now().zero


def test_what_is_found_is_written_down_and_in_force_without_a_restart(robot):
    def finished() -> bool:
        if progress(robot)["phase"] == "refused":
            spinning(robot, 50)
        return progress(robot)["phase"] == "done"

    pid = robot.capability("attitude")["pid"]
    spinning(robot, 50)
    until(finished, what="the calibration ends")
    assert progress(robot)["coverage"] > 0.75
    until(lambda: robot.ask("attitude/state")["calibrated"], what="it is in force")
    until(lambda: {"mag_offset_x_ut", "mag_matrix_00", "mag_matrix_22"} <= calibrated(robot), what="it is written down")
    assert robot.capability("attitude")["pid"] == pid
    until(lambda: robot.ask("drive/state")["holder"] is None, what="the base is let go")
