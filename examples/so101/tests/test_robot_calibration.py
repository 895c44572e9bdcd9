"""A hand calibrates an arm whose servos are mounted unlike its rows; from then on its rows are right."""

import sqlite3
from contextlib import closing

import pytest
from robots import arms, setting, until

pytestmark = pytest.mark.timeout(100)
MOUNTED = """json('{"leader_shoulder_pan": {"zero_rad": 0.35, "sign": -1}, "leader_gripper": {"zero_rad": -0.2}}')"""
ZERO = {"leader_shoulder_lift": 0, "leader_elbow_flex": 0, "leader_wrist_flex": 0, "leader_gripper": 0}


def row(robot, name):
    with closing(sqlite3.connect(robot.robot.home / "robot.db")) as database:
        return database.execute(
            "SELECT zero_rad, sign, lower_rad, upper_rad FROM joint WHERE robot = 'so101' AND name = ?", (name,)
        ).fetchone()


def test_rows_are_learnt_from_a_hand_and_are_in_force():
    with arms(setting("world", mounted=MOUNTED)) as robot:

        def hand(joint, degrees):
            robot.say(f"/hand/{joint}/{degrees}")
            world = lambda: robot.robot.ask("world/pose")["joints"][joint]  # noqa: E731
            until(lambda: abs(world() - degrees * 3.14159 / 180) < 0.04, f"{joint} at {degrees}")
            seen = robot.state("leader_arm")["sweep"]
            until(lambda: robot.state("leader_arm")["sweep"] > seen + 2, "its driver has looked there")

        for joint, degrees in ZERO.items():
            hand(joint, degrees)
        assert robot.at("leader_shoulder_pan", "leader_joints") == pytest.approx(0.35, abs=0.05)
        robot.say("/leader/calibrate/zero")
        for joint, ends in (("leader_shoulder_pan", (80, -80, 0)), ("leader_gripper", (95, -9))):
            for degrees in ends:
                hand(joint, degrees)
        said = robot.say("/leader/calibrate/done")
        assert "6 joint rows were written" in said["data"]["reason"]
        until(lambda: row(robot, "leader_shoulder_pan")[1] == -1, "the row of the pan")
        zero_rad, _, lower_rad, upper_rad = row(robot, "leader_shoulder_pan")
        assert zero_rad == pytest.approx(0.35, abs=0.05)
        assert (lower_rad, upper_rad) == (pytest.approx(-1.36, abs=0.1), pytest.approx(1.36, abs=0.1))
        assert row(robot, "leader_gripper")[0] == pytest.approx(-0.2, abs=0.07)
        assert row(robot, "shoulder_pan") == (0.0, 1, -1.9, 1.9), "the follower's are as they were"

        def right():
            at = robot.joints("leader_joints").get("leader_shoulder_pan", {}).get("position_rad")
            world = (robot.robot.ask("world/pose") or {}).get("joints", {}).get("leader_shoulder_pan")
            return at is not None and world is not None and abs(at - world) < 0.06 and robot.pid("leader_joints")

        until(right, "the leader's joints are where the world has them")
