"""A dancing robot whose dance is killed in mid-move stands."""

import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.robot import Robot, prepare, running, until

pytestmark = [pytest.mark.slow_start, pytest.mark.timeout(30)]


@pytest.fixture(scope="module")
def running_robot() -> Iterator[Robot]:
    """A robot that dances, with a speaker to be heard by."""
    with (
        tempfile.TemporaryDirectory(prefix="lbr-") as place,
        running(prepare(Path(place) / "h", "dance", "speech")) as robot,
    ):
        until(lambda: robot.capability("dance")["phase"] == "ready")
        until(lambda: robot.ask("speech/state"), what="speech is there")
        yield robot


@pytest.fixture
def dancer(running_robot: Robot) -> Robot:
    """The robot in the midst of a move to the song that is always there."""
    begin(running_robot)
    return running_robot


def begin(robot: Robot) -> None:
    """Dance, and return in the midst of a move."""
    assert robot.line("/d/metronome")["text"] == "dances to_and_fro to metronome"
    until(lambda: max(map(abs, wheels(robot))) > 0.1, what="the first move")


def wheels(robot: Robot) -> tuple[float, float]:
    """What the motor driver has applied."""
    state = robot.ask("motors/state")
    return state["left"], state["right"]


def test_a_killed_dance_leaves_the_wheels_standing_and_its_next_life_does_not_go_on(dancer):
    os.kill(dancer.capability("dance")["pid"], signal.SIGKILL)
    until(lambda: wheels(dancer) == (0.0, 0.0), limit_s=2.0, what="the wheels stand")
    until(lambda: dancer.capability("dance")["restarts"] == 1 and dancer.capability("dance")["phase"] == "ready")
    assert dancer.ask("dance/state")["phase"] == "resting"
    assert dancer.ask("drive/state")["holder"] is None
    assert wheels(dancer) == (0.0, 0.0)


def test_a_stop_of_the_base_is_the_end_of_the_dance_and_of_its_song(dancer):
    assert dancer.ask("speech/state")["playing"] == "metronome"
    dancer.line("s")
    ended = until(lambda: (state := dancer.ask("dance/state"))["phase"] == "ended" and state, limit_s=2.0)
    assert "stopped by" in ended["reason"]
    assert wheels(dancer) == (0.0, 0.0)
    until(lambda: dancer.ask("speech/state")["playing"] == "", limit_s=2.0, what="the song ends")


def test_an_emergency_stop_is_the_end_of_the_dance_and_its_release_moves_nothing(dancer):
    dancer.line("estop")
    ended = until(lambda: (state := dancer.ask("dance/state"))["phase"] == "ended" and state, limit_s=2.0)
    assert "emergency stop" in ended["reason"]
    until(lambda: dancer.line("reset")["code"] == 0, what="the emergency stop is released")
    assert wheels(dancer) == (0.0, 0.0)
    assert dancer.ask("drive/state")["holder"] is None
