"""The joints of the rows: angles of servos and back, limits, and what a mirror shows."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.operations.joints.joints_bench import BODY, NAMES


@given(st.sampled_from(NAMES), st.floats(-10.0, 10.0))
def test_an_angle_survives_the_way_to_its_servo_and_back(name, angle_rad):
    assert BODY.joint_rad(name, BODY.servo_rad(name, angle_rad)) == pytest.approx(angle_rad, abs=1e-12)


def test_mirrored_joints_count_alike_though_their_servos_turn_the_other_way():
    assert BODY.servo_rad("right_shoulder_pitch", 0.5) == -1.0
    assert BODY.servo_rad("left_shoulder_pitch", 0.5) == 1.0


@pytest.mark.parametrize(
    ("name", "angle_rad"), [("left_knee", 0.2), ("left_knee", float("nan")), ("left_kne", 0.0), ("x" * 500, 0.0)]
)
def test_an_angle_is_refused_naming_joint_and_limits(name, angle_rad, wording):
    assert BODY.refusal("left_knee", -1.0) is BODY.refusal("left_knee", 0.1) is None
    wording(BODY.refusal(name, angle_rad))


@given(st.dictionaries(st.sampled_from([name for name in NAMES if BODY.partner(name)]), st.floats(-3.0, 3.0)))
def test_a_mirror_in_a_mirror_shows_the_pose_itself(positions):
    assert BODY.mirrored(BODY.mirrored(positions)) == positions


def test_a_mirror_swaps_the_sides_and_turns_the_head_the_other_way():
    shown = BODY.mirrored({"left_knee": -1.0, "right_shoulder_pitch": 0.5, "head_yaw": 0.3})
    assert shown == {"right_knee": -1.0, "left_shoulder_pitch": 0.5, "head_yaw": -0.3}


def test_a_joint_without_another_side_has_no_partner():
    assert BODY.partner("right_grip") == ""
