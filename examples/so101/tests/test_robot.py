"""The whole robot: two arms on two buses, each by itself; poses; the emergency stop."""

import pytest
from robots import arms, until

pytestmark = pytest.mark.timeout(100)


def test_two_arms_are_told_apart_take_poses_and_stop():
    with arms() as robot:
        assert robot.torques() == robot.torques("leader_arm") == [0.0] * 6
        assert sorted(robot.joints("leader_joints")) == sorted(f"leader_{name}" for name in robot.joints())
        robot.torque_on()
        assert robot.torques("leader_arm") == [0.0] * 6
        ended = robot.play("/play/ready")
        assert ended["code"] == "done", ended
        assert robot.at("gripper") == pytest.approx(0.8, abs=0.06)
        assert robot.at("leader_gripper", "leader_joints") == pytest.approx(0.0, abs=0.06)
        world = robot.robot.ask("world/pose")["joints"]
        assert world["elbow_flex"] == pytest.approx(robot.at("elbow_flex"), abs=0.05)

        robot.torque_on("/leader/torque/on", "leader_arm")
        assert robot.play("/leader/play/leader_stretched")["code"] == "done"
        assert robot.at("leader_shoulder_pan", "leader_joints") == pytest.approx(0.3, abs=0.06)
        assert robot.at("shoulder_pan") == pytest.approx(0.0, abs=0.06)

        robot.say("estop")
        until(lambda: robot.state("arm")["estop"] and robot.state("leader_arm")["estop"], "both arms stopped")
        assert all(robot.torques())
        assert all(robot.torques("leader_arm"))
        robot.say("reset")
        robot.say("/leader/torque/off")
        until(lambda: robot.torques("leader_arm") == [0.0] * 6, "a leader without torque")
        assert all(robot.torques())
        until(lambda: robot.robot.ask("world/pose")["joints"]["leader_shoulder_lift"] > 0.3, "it falls")
