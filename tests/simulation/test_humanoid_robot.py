"""The simulated Bioloid as one robot: a command moves a body that obeys gravity, and the servos' bus says so."""

from math import radians

import pytest

from tests.support.robot import prepare, running
from tests.support.waiting import STOPS_S, until

JOINT, RAISED_RAD = "left_shoulder_roll", radians(40.0)
NEEDED = ("world", "servos", "joints")


@pytest.mark.slow_start
def test_a_command_raises_an_arm_of_a_robot_that_stands_by_itself(tmp_path):
    others = f"UPDATE capability SET enabled = 0 WHERE robot = 'bioloid' AND name NOT IN {NEEDED}"
    home = prepare(tmp_path / "home", edits=(others,))
    with running(home, profile="bioloid-sim") as robot:

        def stands_by_itself():
            robot.line("/torque/on")  # a machine that held the joints up has had the servos let go
            return not robot.ask("world/pose")["held"]

        until(stands_by_itself, limit_s=STOPS_S, what="the hand lets go")
        lease = ""

        def raised():
            nonlocal lease
            command = {"positions": {JOINT: RAISED_RAD}, "speed_rps": 1.5, "lease": lease, "ttl_s": 1.0}
            lease = robot.ask("joints/command", command).get("lease", "")
            return robot.ask("world/pose")["joints"][JOINT] > RAISED_RAD - 0.1

        until(raised, what="the arm is raised")

        def apart_rad():
            said = robot.ask("joints/state")["joints"][JOINT]
            return abs(said["position_rad"] - robot.ask("world/pose")["joints"][JOINT])

        until(lambda: apart_rad() < 0.02, what="the bus says where it is")
        pose = robot.ask("world/pose")
        assert (pose["upright"], pose["on_floor"]) == (True, ["left_foot", "right_foot"])
        assert pose["supply_v"] == pytest.approx(12.0, abs=0.5)
