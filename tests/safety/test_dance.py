"""A dancing robot whose dance is killed in mid-move stands."""

import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.robot import Robot, prepare, running
from tests.support.waiting import STOPS_S, until

pytestmark = [pytest.mark.slow_start]


@pytest.fixture(scope="module")
def running_robot() -> Iterator[Robot]:
    """A robot that dances, with a speaker to be heard by."""
    with (
        tempfile.TemporaryDirectory(prefix="lbr-") as place,
        running(prepare(Path(place) / "h", "dance", "speech")) as robot,
    ):
        told(robot, "dance/state")
        told(robot, "speech/state")
        yield robot


@pytest.fixture
def dancer(running_robot: Robot) -> Robot:
    """The robot in the midst of a move to the song that is always there."""
    begin(running_robot)
    return running_robot


def begin(robot: Robot) -> None:
    """Dance, and return in the midst of a move; on a busy machine a lease may lapse before, and the dance with it."""

    def look() -> bool:
        if told(robot, "dance/state")["phase"] != "dancing":
            robot.line("/d/metronome")
        return max(map(abs, wheels(robot))) > 0.1

    until(look, what="the first move")


def wheels(robot: Robot) -> tuple[float, float]:
    """What the motor driver has applied."""
    state = told(robot, "motors/state")
    return state["left"], state["right"]


def told(robot: Robot, key: str) -> dict[str, Any]:
    """What a capability says of itself; one of low rank may take its time on a busy machine."""
    return until(lambda: robot.ask(key), what=f"{key} is told")


def wait_for_the_end(robot: Robot) -> None:
    """Wait until the dance says that it ended; why, a busy machine has its own reasons."""
    until(lambda: told(robot, "dance/state")["phase"] == "ended", what="the dance ends")


def test_a_killed_dance_leaves_the_wheels_standing_and_its_next_life_does_not_go_on(dancer):
    os.kill(dancer.capability("dance")["pid"], signal.SIGKILL)
    until(lambda: wheels(dancer) == (0.0, 0.0), limit_s=STOPS_S, what="the wheels stand")
    until(
        lambda: (unit := dancer.capability("dance"))["restarts"] == 1 and unit["phase"] == "ready",
        what="dance lives again",
    )
    assert told(dancer, "dance/state")["phase"] == "resting"
    assert told(dancer, "drive/state")["holder"] is None
    assert wheels(dancer) == (0.0, 0.0)


def test_a_stop_of_the_base_is_the_end_of_the_dance_and_of_its_song(dancer):
    until(lambda: told(dancer, "speech/state")["playing"] == "metronome", what="the song is played")
    dancer.line("s")
    wait_for_the_end(dancer)
    assert wheels(dancer) == (0.0, 0.0)
    until(lambda: told(dancer, "speech/state")["playing"] == "", what="the song ends")


def test_an_emergency_stop_is_the_end_of_the_dance_and_its_release_moves_nothing(dancer):
    dancer.line("estop")
    wait_for_the_end(dancer)
    until(lambda: dancer.line("reset")["code"] == 0, what="the emergency stop is released")
    assert wheels(dancer) == (0.0, 0.0)
    assert told(dancer, "drive/state")["holder"] is None
