"""A base that a capability moves by itself stands when that is killed or stopped, and its next life does not go on."""

import os
import signal
import sqlite3
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.support.robot import Robot, lbr, prepare, running
from tests.support.trace import Trace
from tests.support.waiting import STOPS_S, until

pytestmark = [pytest.mark.slow_start]
TABLE = """Type,Current State,Time,O:level,O:retry,O:turn,Next State
start,Ahead,,0.15,10,,Waiting
,Waiting,>= 600,,,,Home
end,Home,,,,,
fail,Failed,,0,,,
"""
"""It drives without an end: whoever renews that is gone with the process."""
FASTER = "UPDATE capability SET settings = json_set(settings, '$.spin_power', 0.4) WHERE name = 'attitude'"


class Mover(NamedTuple):
    """A capability, the line by which it begins to move the base, and the phases that it tells at `state`."""

    name: str
    line: str
    state: str
    moves: frozenset[str]
    ended: str


MOVERS = (
    Mover("behaviour", "/behaviour/run/creep", "behaviour/state", frozenset({"running", "paused"}), "ended"),
    Mover("dance", "/d/metronome", "dance/state", frozenset({"dancing"}), "ended"),
    Mover("attitude", "/m/2000/-", "attitude/calibration", frozenset({"collecting", "fitting"}), "refused"),
)


@pytest.fixture(scope="module")
def robot() -> Iterator[Robot]:
    """A robot with a table of its own, music, and an inertial unit whose compass it can calibrate."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        home = prepare(Path(place) / "h", "behaviour", "dance", "speech", "imu", "attitude", edits=(FASTER,))
        (Path(place) / "creep.csv").write_text(TABLE, encoding="utf-8")
        done = lbr(home, "behaviour", "import", str(Path(place) / "creep.csv"))
        assert done.returncode == 0, done.stderr
        with running(home) as started:
            for key in ("behaviour/state", "dance/state", "speech/state"):
                told(started, key)
            yield started


@pytest.fixture(params=MOVERS, ids=lambda mover: mover.name)
def mover(robot: Robot, request: pytest.FixtureRequest) -> Mover:
    """One that moves the base now."""
    move(robot, request.param)
    return request.param


def move(robot: Robot, mover: Mover) -> None:
    """Have the base be moved; on a busy machine a lease may lapse before, and the motion with it."""
    trace = Trace(robot.trace)

    def look() -> bool:
        if phase(robot, mover) not in mover.moves:
            robot.line(mover.line)
        return trace.now().least > 0.05

    until(look, what=f"{mover.name} moves the wheels")


def phase(robot: Robot, mover: Mover) -> str:
    return str((robot.ask(mover.state) or {}).get("phase"))


def told(robot: Robot, key: str) -> dict[str, Any]:
    """What a capability says of itself; one of low rank may take its time on a busy machine."""
    return until(lambda: robot.ask(key), what=f"{key} is told")


def stands(robot: Robot) -> None:
    """Wait until the wheels stand and nobody holds the base."""
    until(lambda: Trace(robot.trace).now().zero, what="the wheels stand")
    until(lambda: told(robot, "drive/state")["holder"] is None, what="nobody holds the base")


def test_a_killed_mover_leaves_the_wheels_standing_and_its_next_life_does_not_go_on(robot, mover):
    trace, pid = Trace(robot.trace), robot.capability(mover.name)["pid"]
    killed_ns = time.monotonic_ns()
    os.kill(pid, signal.SIGKILL)
    zero = trace.first_zero(killed_ns, STOPS_S)
    assert zero is not None, "the wheels still turn"
    until(
        lambda: (unit := robot.capability(mover.name))["pid"] not in {None, pid} and unit["phase"] == "ready",
        what=f"{mover.name} lives again",
    )
    assert phase(robot, mover) not in mover.moves
    trace.read()
    assert [output for output in trace.outputs(zero.at_ns + 1) if not output.zero] == []
    assert told(robot, "drive/state")["holder"] is None


@pytest.mark.parametrize("line", ["s", "estop"])
def test_a_stop_is_the_end_of_what_it_does_and_a_release_moves_nothing(robot, mover, line):
    robot.line(line)
    until(lambda: phase(robot, mover) == mover.ended, what=f"{mover.name} ends")
    if line == "estop":
        until(lambda: robot.line("reset")["code"] == 0, what="the emergency stop is released")
    stands(robot)
    assert phase(robot, mover) == mover.ended


def test_a_song_ends_with_its_dance(robot):
    move(robot, MOVERS[1])
    until(lambda: told(robot, "speech/state")["playing"] == "metronome", what="the song is played")
    robot.line("s")
    until(lambda: told(robot, "speech/state")["playing"] == "", what="the song ends")


def test_a_calibration_is_written_down_and_in_force_without_a_restart(robot):
    mover, pid = MOVERS[2]._replace(line="/m/50/-"), robot.capability("attitude")["pid"]

    def finished() -> bool:
        if phase(robot, mover) == mover.ended:
            move(robot, mover)
        return phase(robot, mover) == "done"

    move(robot, mover)
    until(finished, what="the calibration ends")
    assert told(robot, mover.state)["coverage"] > 0.75
    until(lambda: robot.ask("attitude/state")["calibrated"], what="it is in force")
    until(lambda: {"mag_offset_x_ut", "mag_matrix_00", "mag_matrix_22"} <= calibrated(robot), what="it is written down")
    assert robot.capability("attitude")["pid"] == pid
    stands(robot)


def calibrated(robot: Robot) -> set[str]:
    """What the rows know of the inertial unit."""
    database = sqlite3.connect(robot.home / "robot.db")
    names = {name for (name,) in database.execute("SELECT name FROM calibration WHERE device = 'imu'")}
    database.close()
    return names


def test_a_table_that_is_edited_away_under_its_run_stops_the_robot_and_the_process_goes_on(robot):
    mover = MOVERS[0]
    move(robot, mover)
    pid = robot.capability("behaviour")["pid"]
    robot.edit("UPDATE behaviour SET help = 'creeps' WHERE name = 'creep'")
    until(lambda: "creeps" in robot.line("/behaviour/list")["text"], what="the edit is known")
    robot.edit("DELETE FROM behaviour_row WHERE behaviour = 'creep'")
    robot.edit("DELETE FROM behaviour WHERE name = 'creep'")
    until(lambda: phase(robot, mover) == mover.ended, what="the run ends")
    assert told(robot, mover.state)["code"] != "done"
    stands(robot)
    assert robot.capability("behaviour")["pid"] == pid
