"""The small robot, started by `lbr run`: it drives by its emulated controller, and stops when its driver is killed."""

import os
import signal

import pytest

from lbr.testing.robot import NoAnswerError, running, until

SLOWLY_S = 45.0
"""Limits waiting on a busy machine."""
pytestmark = pytest.mark.timeout(150)


@pytest.fixture(scope="module")
def claw():
    with running("claw-sim") as robot:
        until(lambda: all(phase == "ready" for phase in phases(robot).values()), "all is ready", SLOWLY_S)
        yield robot


def capabilities(robot):
    return (robot.ask("@status") or {"capabilities": []})["capabilities"]


def phases(robot):
    return {one["name"]: one["phase"] for one in capabilities(robot)} or {"": "unknown"}


def speed(robot):
    pose = robot.ask("world/pose")
    return pose["speed_mps"] if pose else None


def drives(robot):
    """Drive back, by a motion that is repeated until the wheels turn."""

    def moving():
        try:
            robot.say("/r/0.3/180")
        except NoAnswerError:
            return False
        return (speed(robot) or 0.0) < -0.02

    until(moving, "it drives back", SLOWLY_S)


def test_it_drives_and_its_odometry_counts(claw):
    drives(claw)
    until(lambda: (claw.ask("odometry/state") or {"distance_m": 0.0})["distance_m"] != 0.0, "its odometry", SLOWLY_S)
    assert claw.say("s")["text"] == "stopped"
    until(lambda: abs(speed(claw) or 0.0) < 0.01, "it stands", SLOWLY_S)


def test_it_stands_when_its_driver_is_killed_and_drives_again_with_the_next(claw):
    drives(claw)
    pid = next(one["pid"] for one in capabilities(claw) if one["name"] == "motors")
    os.kill(pid, signal.SIGKILL)
    until(lambda: abs(speed(claw) or 1.0) < 0.01, "it stands", SLOWLY_S)
    until(lambda: phases(claw)["motors"] == "ready", "the next driver", SLOWLY_S)
    drives(claw)
    claw.say("s")
