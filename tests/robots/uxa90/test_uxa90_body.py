"""The UXA-90's body as a bystander sees it: how it rests, what moves where, and the motions that its main board plays."""

from itertools import pairwise
from math import radians

import numpy as np
import pytest

from lbr.errors import InputError
from lbr.messages.joints import MotionRow
from lbr.robots.uxa90.twin.firmware import shipped
from lbr.simulation.humanoid.settings import Motor, Motors
from lbr.simulation.measured import ServoDrive
from tests.models.uxa90.robot import Robot, humanoid, joints
from tests.support import databases

FEET = ("left_foot", "right_foot")
STAND, BASIC, STEP, SIT = 7, 1, 4, 21


def driven(pose, **more):
    return {
        joint.device_id: ServoDrive(
            goal_rad=joint.zero_rad + joint.sign * pose.get(joint.name, 0.0), torque=1.0, **more
        )
        for joint in joints()
    }


@pytest.fixture(scope="module")
def hung():
    """One that hangs on a stand, and where its parts are with every joint at zero."""
    engine = humanoid(rests={}, stand=True)
    engine.step(driven({}), 0.5)
    return engine


def test_it_is_as_tall_and_heavy_as_published_and_its_soles_are_on_the_floor(hung):
    model = hung.body.model
    assert sum(model.body_mass) == pytest.approx(10.95, abs=0.1)
    head = model.geom_bodyid == model.body("head").id
    top = (hung.data.geom_xpos[head, 2] + model.geom_aabb[head, 5]).max() - hung.data.qpos[2]
    assert top + model.body_pos[hung.body.trunk, 2] == pytest.approx(1.01, abs=0.01)
    assert hung._lowest_m() == pytest.approx(0.05, abs=0.005)


@pytest.mark.parametrize(
    ("joint", "part", "axis", "sense"),
    [
        ("neck_yaw", "camera", 1, 1),
        ("waist_yaw", "camera", 1, 1),
        ("head_pitch", "camera", 2, -1),
        ("left_shoulder_pitch", "left_fingers", 0, 1),
        ("right_shoulder_pitch", "right_fingers", 0, 1),
        ("left_shoulder_roll", "left_fingers", 1, 1),
        ("right_shoulder_roll", "right_fingers", 1, -1),
        ("left_elbow", "left_fingers", 0, -1),
        ("right_elbow", "right_fingers", 0, -1),
        ("left_hip_pitch", "left_foot", 0, 1),
        ("right_hip_pitch", "right_foot", 0, 1),
        ("left_hip_roll", "left_foot", 1, 1),
        ("right_hip_roll", "right_foot", 1, -1),
        ("left_knee", "left_foot", 0, 1),
        ("right_knee", "right_foot", 0, 1),
        ("left_ankle_pitch", "left toes", 2, 1),
        ("right_ankle_pitch", "right toes", 2, 1),
        ("left_hip_yaw", "left toes", 1, 1),
        ("right_hip_yaw", "right toes", 1, -1),
    ],
)
def test_a_positive_angle_turns_a_part_the_way_that_the_rows_mean(hung, joint, part, axis, sense):
    def place():
        if part == "camera":
            return -hung.data.camera("head").xmat.reshape(3, 3)[:, 2]
        if part.endswith("toes"):
            return hung.data.body(f"{part.split()[0]}_foot").xmat.reshape(3, 3)[:, 0].copy()
        return hung.data.body(part).xpos.copy()

    turn = -0.3 if joint.endswith(("elbow", "knee")) else 0.3
    hung.step(driven({}), 0.6)
    before = place()
    hung.step(driven({joint: turn}), 0.6)
    assert (place() - before)[axis] * sense * np.sign(turn) > 0.03


def test_mirrored_joints_at_the_same_angle_are_a_symmetrical_pose(hung):
    pose = {
        f"{side}_{joint}": 0.3
        for side in ("left", "right")
        for joint in ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "hand", "hip_yaw", "hip_roll", "hip_pitch")
    }
    hung.step(driven(pose), 1.0)
    for part in ("forearm", "fingers", "shin", "foot"):
        left, right = (hung.data.body(f"{side}_{part}").xpos - hung.data.qpos[:3] for side in ("left", "right"))
        assert left == pytest.approx(right * (1, -1, 1), abs=0.003)


def test_limp_it_sits_on_its_feet_for_as_long_as_one_likes_and_nobody_holds_it():
    engine = humanoid()
    begun = engine.pose()
    engine.step({}, 20.0)
    rested = engine.pose()
    for pose in (begun, rested):
        assert (pose.upright, pose.stands, pose.held) == (True, False, False)
    assert rested.on_floor == FEET
    assert rested.z_m == pytest.approx(begun.z_m, abs=0.01)
    assert abs(rested.x_m) < 0.01
    for joint in joints():
        assert joint.lower_rad < rested.joints[joint.name] < joint.upper_rad


def test_it_stands_up_takes_the_walking_stance_steps_ahead_and_sits_down_limp():
    robot = Robot()
    low = robot.engine.pose().z_m
    stood = robot.play(STAND)
    assert robot.board.programmes[STAND].duration_s <= 7.0
    assert (stood.stands, stood.on_floor) == (True, FEET)
    assert stood.z_m > low + 0.25
    assert max(abs(angle) for angle in stood.joints.values()) < 0.06
    basic = robot.play(BASIC)
    assert basic.stands
    assert basic.joints["left_knee"] == pytest.approx(-0.758, abs=0.06)
    ahead = robot.play(STEP)
    assert ahead.stands
    assert ahead.x_m - basic.x_m == pytest.approx(0.07, abs=0.03)
    assert {pose.on_floor for pose in robot.seen} >= {("left_foot",), ("right_foot",)}, "each foot has left the floor"
    down = robot.play(SIT)
    assert (down.upright, down.stands, down.on_floor) == (True, False, FEET)
    sinking_mps = max((a.z_m - b.z_m) / (b.time_s - a.time_s) for a, b in pairwise(robot.seen))
    assert sinking_mps < 0.2, "it does not crash down"
    assert not any(drive.torque for drive in robot.board.drives(robot.now).values())
    assert robot.play(STAND).stands


def test_motions_end_in_the_walking_stance_and_last_as_long_as_their_rows_say():
    programmes = shipped()
    basic = programmes[BASIC].ends_at()
    assert [slot for slot, programme in programmes.items() if programme.ends_at() != basic] == [STAND, SIT]
    rows = databases.of_robot("uxa90").of(MotionRow)
    lasts = {row.slot: row.slot_s for row in rows if row.slot is not None and row.builtin}
    assert {slot: pytest.approx(programme.duration_s) for slot, programme in programmes.items()} == lasts


def test_whoever_lies_is_put_back_as_it_began_where_it_is():
    engine = humanoid()
    engine.step(driven({}), 2.0)
    engine.step({}, 4.0)
    assert not engine.pose().stands
    engine.pick_up()
    engine.step({}, 1.0)
    back = engine.pose()
    assert (back.upright, back.held, back.on_floor) == (True, False, FEET)
    assert back.joints["left_knee"] == pytest.approx(-2.4, abs=0.02)


def test_picked_up_with_torque_it_is_held_on_its_feet_until_it_stands():
    engine = humanoid()
    engine.step(driven({}), 0.0)
    engine.pick_up()
    assert engine.held
    engine.step(driven({}), 4.0)
    assert (engine.held, engine.pose().stands) == (False, True)


def test_a_shorted_motor_lets_its_limb_sink_slowly_and_a_limp_one_lets_it_fall():
    sunk = {}
    for brake in (False, True):
        engine = humanoid(rests={}, stand=True)
        engine.step(driven({"left_shoulder_roll": 1.5}), 1.5)
        begun = engine.pose().joints["left_shoulder_roll"]
        engine.step({joint.device_id: ServoDrive(brake=brake) for joint in joints()}, 0.25)
        sunk[brake] = begun - engine.pose().joints["left_shoulder_roll"]
    assert sunk[False] > 0.3
    assert sunk[True] < 0.5 * sunk[False]


def test_motors_differ_by_joint_and_patterns_that_fit_nothing_are_named():
    knees = Motors(joints=("*_knee",), stall_nm=20.0)
    chosen = humanoid(motor=Motor(stall_nm=3.0), motors=(knees,)).settings.motors_of(["left_knee", "left_elbow"])
    assert [motor.stall_nm for motor in chosen] == [20.0, 3.0]
    with pytest.raises(InputError, match=r"`motors`: there is no joint '\*_wing'"):
        humanoid(motors=(Motors(joints=("*_wing",)),))
    with pytest.raises(InputError, match="`rests`: there is no joint 'tail'"):
        humanoid(rests={"tail": radians(5.0)})
