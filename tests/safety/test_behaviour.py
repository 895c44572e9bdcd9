"""A robot that a table moves stands when the table's process is killed, stopped or taken away; and follows an edit."""

import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.robot import Robot, lbr, prepare, running
from tests.support.waiting import STOPS_S, until

pytestmark = [pytest.mark.slow_start]
TABLE = """Type,Current State,Time,O:level,O:retry,O:turn,Next State
start,Ahead,,0.15,10,,Waiting
,Waiting,>= 600,,,,Home
end,Home,,,,,
fail,Failed,,0,,,
"""
"""It drives without an end: whoever renews that is gone with the process."""


@pytest.fixture(scope="module")
def running_robot() -> Iterator[Robot]:
    """A robot with a table of its own."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        home = prepare(Path(place) / "h", "behaviour")
        (Path(place) / "creep.csv").write_text(TABLE, encoding="utf-8")
        done = lbr(home, "behaviour", "import", str(Path(place) / "creep.csv"))
        assert done.returncode == 0, done.stderr
        with running(home) as robot:
            told(robot, "behaviour/state")
            yield robot


@pytest.fixture
def mover(running_robot: Robot) -> Robot:
    """The robot on its way, as its table says; on a busy machine a lease may lapse before, and the table with it."""

    def look() -> bool:
        if told(running_robot, "behaviour/state")["phase"] not in {"running", "paused"}:
            running_robot.line("/behaviour/run/creep")
        return max(map(abs, wheels(running_robot))) > 0.05

    until(look, what="it drives")
    return running_robot


def wheels(robot: Robot) -> tuple[float, float]:
    """What the motor driver has applied."""
    state = told(robot, "motors/state")
    return state["left"], state["right"]


def told(robot: Robot, key: str) -> dict[str, Any]:
    """What a capability says of itself; one of low rank may take its time on a busy machine."""
    return until(lambda: robot.ask(key), what=f"{key} is told")


def test_a_killed_table_leaves_the_wheels_standing_and_its_next_life_does_not_go_on(mover):
    os.kill(mover.capability("behaviour")["pid"], signal.SIGKILL)
    until(lambda: wheels(mover) == (0.0, 0.0), limit_s=STOPS_S, what="the wheels stand")
    until(
        lambda: (unit := mover.capability("behaviour"))["restarts"] == 1 and unit["phase"] == "ready",
        what="behaviour lives again",
    )
    assert told(mover, "behaviour/state")["phase"] == "resting"
    assert told(mover, "drive/state")["holder"] is None
    assert wheels(mover) == (0.0, 0.0)


@pytest.mark.parametrize("line", ["s", "estop"])
def test_every_stop_is_the_end_of_the_run(mover, line):
    mover.line(line)
    until(lambda: told(mover, "behaviour/state")["phase"] == "ended", what="the run ends")
    until(lambda: wheels(mover) == (0.0, 0.0), what="the wheels stand")
    if line == "estop":
        assert mover.line("/behaviour/run/creep")["code"] != 0
        until(lambda: mover.line("reset")["code"] == 0, what="the emergency stop is released")
    assert wheels(mover) == (0.0, 0.0)


def test_a_table_that_is_edited_away_under_its_run_stops_the_robot_and_the_process_goes_on(mover):
    pid = mover.capability("behaviour")["pid"]
    mover.edit("UPDATE behaviour SET help = 'creeps' WHERE name = 'creep'")
    until(lambda: "creeps" in mover.line("/behaviour/list")["text"], what="the edit is known")
    mover.edit("DELETE FROM behaviour_row WHERE behaviour = 'creep'")
    mover.edit("DELETE FROM behaviour WHERE name = 'creep'")
    state = until(lambda: (found := told(mover, "behaviour/state"))["phase"] == "ended" and found, what="the run ends")
    assert state["code"] != "done"
    until(lambda: wheels(mover) == (0.0, 0.0), what="the wheels stand")
    assert mover.capability("behaviour")["pid"] == pid
