"""Fallen, the simulated humanoids get up by the motions of their rows."""

import pytest

from lbr.operations.joints.trajectory import plan
from tests.support import needs

needs.modules("mujoco")

from tests.models import get_up  # noqa: E402
from tests.models.feet import known  # noqa: E402


@pytest.mark.parametrize(("robot", "side"), [(robot, side) for robot, ways in get_up.WAYS.items() for side in ways])
def test_it_gets_up_from_where_it_has_fallen(robot, side):
    assert get_up.gets_up(robot, side, 7)


@pytest.mark.parametrize("robot", get_up.WAYS)
def test_stopped_in_the_middle_it_holds(robot):
    one = get_up.fallen(robot, "face", 7)
    way = get_up.frames(one, "get_up_face")
    one.play(way, 5.5)
    one.stop()
    one.run(1.0)
    rests = one.engine.pose().joints
    one.run(0.5)
    assert all(abs(angle - rests[name]) < 0.02 for name, angle in one.engine.pose().joints.items())


@pytest.mark.parametrize("at", [6, 8, 9, 10])
def test_stopped_where_it_is_on_hands_and_feet_or_bends_over_its_feet_the_uxa90_stays_there(at):
    one = get_up.fallen("uxa90", "face", 7)
    way = get_up.frames(one, "get_up_face")[:at]
    one.play(way, sum(frame.duration_s for frame in way) + 0.5)
    before = one.engine.pose()
    one.run(1.5)
    after = one.engine.pose()
    assert set(after.on_floor) - {"left_fingers", "right_fingers"} == {"left_foot", "right_foot"}
    assert abs(after.z_m - before.z_m) < 0.02


@pytest.mark.parametrize("robot", get_up.WAYS)
def test_mirrored_it_rolls_over_its_other_side(robot):
    assert get_up.gets_up(robot, "back", 7, mirror=True)


@pytest.mark.parametrize("name", sorted({*get_up.WAYS["uxa90"].values()}))
def test_what_gets_the_uxa90_up_keeps_to_the_limits_of_its_joints_and_no_way_has_to_be_stretched(name):
    joints, motions, _ = known("uxa90")
    frames = next(motion.frames for motion in motions if motion.name == name)
    limits = {joint.name: joint for joint in joints}
    for frame in frames:
        for joint, angle in frame.positions.items():
            assert limits[joint].lower_rad <= angle <= limits[joint].upper_rad, joint
    way = plan(dict.fromkeys(limits, 0.0), frames, {joint.name: joint.speed_rps for joint in joints})
    assert way.stretch == 1.0, way.slowest
