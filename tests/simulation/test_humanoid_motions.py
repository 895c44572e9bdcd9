"""The motions of the rows, played on the simulated body: they stay within the limits, on their feet and off each other's."""

import re
from math import radians
from pathlib import Path

import pytest

from lbr.messages.joints import KeyFrame
from lbr.operations.joints.settings import JointsSettings
from lbr.operations.joints.trajectory import plan
from tests.simulation.humanoid_bench import Player, frames_of, rows

JOINTS, MOTIONS = rows()
LEGS = {"left_foot", "right_foot"}
STANDING = [name for name in MOTIONS if not MOTIONS[name].lead_in and name != "sit" and not name.startswith("get_up")]
POSES = ("initial", "ready", "walk_ready")


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_keeps_to_the_limits_of_its_joints_and_no_way_has_to_be_stretched(name):
    limits = {joint.name: joint for joint in JOINTS}
    for frame in MOTIONS[name].frames:
        for joint, angle in frame.positions.items():
            assert limits[joint].lower_rad <= angle <= limits[joint].upper_rad, joint
    upright = {**dict.fromkeys(limits, 0.0), **MOTIONS["initial"].frames[0].positions}
    way = plan(upright, frames_of(MOTIONS[name], 3), {joint.name: joint.speed_rps for joint in JOINTS})
    assert way.stretch == 1.0, way.slowest


@pytest.mark.parametrize("name", STANDING)
def test_it_ends_upright_and_at_rest(name):
    player = Player()
    before = player.play(name)
    after = player.play(name)
    assert (after.upright, set(after.on_floor)) == (True, LEGS)
    assert max(abs(pose.roll_rad) for pose in player.seen) < 0.05
    assert max(abs(pose.pitch_rad) for pose in player.seen) < 0.25
    assert abs(after.x_m - before.x_m) < 0.01


@pytest.mark.parametrize("name", POSES)
def test_a_pose_names_every_joint(name):
    assert set(MOTIONS[name].frames[-1].positions) == {joint.name for joint in JOINTS}


def test_it_sits_down_and_stands_up_again():
    player = Player()
    stood = player.play("initial")
    sat = player.play("sit")
    assert stood.z_m - sat.z_m > 0.08
    assert (sat.upright, set(sat.on_floor)) == (True, LEGS)
    back = player.play("stand_up")
    assert back.z_m == pytest.approx(stood.z_m, abs=0.005)
    assert back.upright


def test_waving_raises_the_hand():
    player = Player()
    player.go(MOTIONS["wave"].frames[:3])
    engine = player.engine
    hand, head = (engine.data.body(name).xpos[2] for name in ("right_forearm", "trunk"))
    assert hand - head > 0.08, "its elbow is above its shoulder"


@pytest.mark.parametrize("interpolation", ["smooth", "linear"])
def test_walking_lifts_each_foot_in_turn_and_does_not_fall(interpolation):
    player = Player()
    cycles = 8
    end = player.play("walk", cycles, interpolation)
    assert end.upright
    assert cycles <= player.lifted("left_foot") <= cycles + 3
    assert cycles <= player.lifted("right_foot") <= cycles + 3
    assert max(abs(pose.roll_rad) for pose in player.seen) < 0.2
    alone = [pose.on_floor[0] for pose in player.seen if len(pose.on_floor) == 1]
    turns = [foot for foot, before in zip(alone, [None, *alone], strict=False) if foot != before]
    assert len(turns) >= 2 * cycles
    assert len(alone) / len(player.seen) > 0.2
    assert abs(end.yaw_rad) < 0.1


@pytest.mark.parametrize(
    ("name", "ahead_m", "turned_rad"),
    [("walk", 0.0, 0.0), ("walk_ahead", 0.25, 0.0), ("walk_back", -0.3, 0.0), ("turn_left", 0.0, 1.8)],
)
def test_each_way_of_walking_goes_where_it_says(name, ahead_m, turned_rad):
    end = Player().play(name, 6)
    assert end.upright
    assert (end.x_m, end.y_m) == pytest.approx((ahead_m, 0.0), abs=0.06)
    assert end.yaw_rad == pytest.approx(turned_rad, abs=0.15 + turned_rad / 5)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_stopped_in_the_middle_of_a_step_it_stays_on_its_feet(share):
    player = Player()
    player.go(MOTIONS["walk_ready"].frames)
    player.go(MOTIONS["walk"].frames * 2, until_share=share)
    player.goal = player.engine.pose().joints
    player.go((), hold_s=1.5)
    assert player.engine.pose().upright


@pytest.mark.parametrize("page", ["docs/tutorial.md", "docs/robots/bioloid.md"])
def test_a_joint_that_the_pages_have_you_move_gets_there_from_hanging_arms_and_nothing_is_in_its_way(page):
    said = re.findall(r"\| `/j/(\w+)/(-?\d+)`", (Path(__file__).parents[2] / page).read_text())
    moves = [(joint, radians(float(degrees))) for joint, degrees in said if joint in {one.name for one in JOINTS}]
    assert moves
    for joint, angle in moves:
        player = Player()
        player.go((KeyFrame(positions={joint: angle}, duration_s=abs(angle) / radians(30.0)),), hold_s=0.5)
        away = {name: abs(player.engine.pose().joints[name] - goal) for name, goal in player.goal.items()}
        assert max(away.values()) < JointsSettings().tolerance_rad, away
        assert player.engine.pose().upright
