"""Capturing: the pose of now becomes a key frame that can be played at once."""

from math import radians

from lbr.messages.joints import MotionRow
from tests.operations.motions.motions_bench import JOINTS


def test_the_pose_of_now_becomes_a_motion_that_is_played_at_once(stage, world):
    world.pose |= {"right_elbow": -1.23456, "neck": 0.5}
    call = stage.capture("bow", duration_s=1.5, help="Bows")
    assert call.answer.accepted
    assert call.answer.reason == "key frame 1 of 'bow' is the pose of now"
    ((motion, step),) = world.kept
    assert motion == MotionRow(name="bow", help="Bows")
    assert (step.motion, step.step, step.duration_s) == ("bow", 1, 1.5)
    assert step.positions == {"right_elbow": -1.2346, "left_elbow": -0.1, "neck": 0.5}
    assert world.events[-1] == ("captured", "console: key frame 1 of 'bow' is the pose of now")
    world.pose["neck"] = 0.0
    assert stage.capture("bow").answer.reason == "key frame 2 of 'bow' is the pose of now"
    stage.run(3.0, stage.begun("bow"))
    assert [one.positions["neck"] for one in world.body.frames] == [0.5, 0.0]
    assert world.said("result")[0].result == "reached"


def test_a_joint_a_little_beyond_its_limit_is_taken_at_its_limit(stage, world):
    lower = JOINTS[0].lower_rad
    world.pose["right_elbow"] = lower - radians(0.9)
    assert stage.capture().answer.accepted
    assert world.kept[0][-1].positions["right_elbow"] == lower


def test_joints_far_beyond_their_limits_are_named(stage, world, wording):
    world.pose["right_elbow"] = JOINTS[0].lower_rad - radians(1.1)
    wording(stage.capture().answer)
    world.pose["neck"] = 2.0
    wording(stage.capture().answer)
    assert world.kept == []


def test_joints_that_were_not_measured_are_named(stage, world, wording):
    world.unmeasured = {"neck": "servo 19 does not answer"}
    wording(stage.capture().answer)
    world.unmeasured = {}
    world.pose["left_elbow"] = float("nan")
    assert "left_elbow (servo 6)" in stage.capture().answer.reason
    assert world.kept == []


def test_joints_that_report_what_is_not_believed_are_named(stage, world, wording):
    world.doubted = {"neck"}
    wording(stage.capture().answer)
    assert world.kept == []


def test_a_motion_that_the_controller_keeps_is_not_added_to(stage, world, wording):
    wording(stage.capture("stand").answer)
    assert world.kept == []


def test_without_news_of_the_joints_nothing_is_captured(stage, world, wording):
    world.told_of_joints = False
    wording(stage.capture().answer)


def test_nothing_is_captured_while_a_motion_is_played(stage, world, wording):
    call = stage.begun("wave")
    stage.run(0.1, call)
    wording(stage.capture().answer)
