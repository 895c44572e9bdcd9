"""A humanoid that a table moves keeps on its feet when the table is stopped or its process killed."""

import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support import needs
from tests.support.robot import Robot, only, prepare, running
from tests.support.waiting import until

needs.modules("mujoco")

pytestmark = [pytest.mark.slow_start]
NEEDED = ("world", "servos", "joints", "motions", "imu", "attitude", "behaviour")
WALKS_FIRST = (
    "DELETE FROM behaviour_row WHERE robot = 'bioloid' AND behaviour = 'show' AND (state = 'Sitting' OR"
    " (outputs ->> 'set' IS NOT NULL AND outputs ->> 'motion' <> 'walk'))"
)
"""Of the show's motions, which come in an order by chance, the walk alone."""


@pytest.fixture(scope="module")
def bioloid() -> Iterator[Robot]:
    """The simulated Bioloid."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        home = prepare(Path(place) / "h", edits=(only("bioloid", *NEEDED), WALKS_FIRST))
        with running(home, profile="bioloid-sim") as robot:
            told(robot, "behaviour/state")
            yield robot


@pytest.fixture
def standing(bioloid: Robot) -> Robot:
    """The robot by itself on its feet, with torque, and moved by nobody."""

    if not told(bioloid, "world/pose")["stands"]:
        bioloid.line("s")
        bioloid.line("/torque/off/all")
        until(lambda: limp(bioloid), what="it is limp")
        bioloid.line("pick_up")
        until(lambda: straight(bioloid), what="its servos are read where the hand has put them")

    def stands() -> bool:
        bioloid.line("/torque/on")  # a machine that held the joints up has had the servos let go
        return on_feet(bioloid) and told(bioloid, "motions/state")["fallen"] == ""

    until(stands, what="it stands by itself")
    return bioloid


def told(robot: Robot, key: str) -> dict[str, Any]:
    """What a capability says of itself."""
    return until(lambda: robot.ask(key), what=f"{key} is told")


def limp(robot: Robot) -> bool:
    """Say whether no joint has torque, so that a hand can straighten them."""
    return all(joint["torque"] == 0.0 for joint in told(robot, "joints/state")["joints"].values())


def straight(robot: Robot) -> bool:
    """Say whether all joints are measured at zero, more or less."""
    measured = [joint["position_rad"] for joint in told(robot, "joints/state")["joints"].values()]
    return all(angle is not None and abs(angle) < 0.1 for angle in measured)


def on_feet(robot: Robot) -> bool:
    """Say whether it stands on its feet, held by nobody."""
    pose = told(robot, "world/pose")
    return bool(pose["stands"] and not pose["held"] and set(pose["on_floor"]) == {"left_foot", "right_foot"})


def plays(robot: Robot, table: str, motion: str) -> None:
    """Run a table until it plays this motion; on a busy machine a lease may lapse before, and the table with it."""

    def look() -> bool:
        state = told(robot, "behaviour/state")
        if state["phase"] != "running":
            robot.line(f"/behaviour/run/{table}")
        playing = told(robot, "motions/state")
        return bool(state["doing"].startswith(f"play {motion}") and playing["playing"])

    until(look, what=f"{table} plays {motion}")


def rests(robot: Robot) -> None:
    """Wait until nothing is played, and the robot is moved by nobody."""
    until(lambda: not told(robot, "motions/state")["playing"], what="nothing is played")
    until(lambda: told(robot, "joints/state")["holder"] is None, what="nobody moves the joints")


def kill(robot: Robot) -> None:
    """Kill the process that runs the table, and wait for its next life."""
    restarts = robot.capability("behaviour")["restarts"]
    os.kill(robot.capability("behaviour")["pid"], signal.SIGKILL)
    rests(robot)
    until(
        lambda: (unit := robot.capability("behaviour"))["restarts"] == restarts + 1 and unit["phase"] == "ready",
        what="behaviour lives again",
    )
    assert told(robot, "behaviour/state")["phase"] == "resting"
    assert not told(robot, "motions/state")["playing"]


def test_a_killed_table_leaves_the_bioloid_on_its_feet_and_its_next_life_does_not_go_on(standing):
    plays(standing, "greet", "wave")
    kill(standing)
    assert on_feet(standing)


@pytest.mark.parametrize("line", ["s", "/behaviour/stop"])
def test_a_show_that_is_stopped_as_it_walks_leaves_the_bioloid_on_its_feet(standing, line):
    plays(standing, "show", "walk")
    standing.line(line)
    until(lambda: told(standing, "behaviour/state")["phase"] == "ended", what="the run ends")
    rests(standing)
    until(lambda: on_feet(standing), what="it stands on both feet")


def test_a_killed_table_has_the_uxa90_stop_as_it_stands_up(tmp_path):
    with running(prepare(tmp_path / "h", edits=(only("uxa90", *NEEDED),)), profile="uxa90-sim") as robot:
        plays(robot, "greet", "reset")
        kill(robot)
        pose = told(robot, "world/pose")
        assert (pose["upright"], sorted(pose["on_floor"])) == (True, ["left_foot", "right_foot"])
