"""A robot that goes after a ball which its own camera sees; when what looks is killed, it comes to stand. Every process is
the real one."""

import os
import signal

import pytest

from tests.support import needs
from tests.support.robot import prepare, running
from tests.support.waiting import until

needs.modules("cv2")
pytestmark = pytest.mark.slow_start
PARTS = ("behaviour", "sighting", "camera_front", "imu", "attitude", "odometry")
BALL = """UPDATE capability SET settings = json_set(settings, '$.balls', json('{"ball": {"x_m": 2.8, "z_m": 1.0, "radius_m": 0.07}}'))
WHERE robot = 'lbr' AND name = 'world'"""
BOUNDED_M = 0.6
"""The longest single move of the table, and what it takes to stop."""


def wheels(robot):
    state = robot.ask("motors/state") or {"left": 0.0, "right": 0.0}
    return max(abs(state["left"]), abs(state["right"]))


def ahead_m(robot):
    return until(lambda: robot.ask("world/pose"))["x_m"]


def test_it_drives_to_a_ball_and_stands_when_its_sighting_is_killed_on_the_way(home):
    with running(prepare(home.parent / "f", *PARTS, edits=(BALL,))) as robot:
        until(lambda: robot.ask("sighting/state"), what="sighting tells")
        until(lambda: robot.line("/behaviour/run/follow")["code"] == 0, what="the table runs")
        until(lambda: (robot.ask("sighting/state") or {}).get("seen"), what="it sees the ball")
        until(lambda: wheels(robot) > 0.1 and ahead_m(robot) > 0.1, what="it drives towards it")
        os.kill(robot.capability("sighting")["pid"], signal.SIGKILL)
        robot.line("/ball/gone")
        began_m = ahead_m(robot)
        until(lambda: wheels(robot) == 0.0, what="the wheels stand")
        assert ahead_m(robot) - began_m < BOUNDED_M
        until(lambda: robot.capability("sighting")["restarts"] == 1, what="sighting lives again")
        assert ahead_m(robot) - began_m < BOUNDED_M
