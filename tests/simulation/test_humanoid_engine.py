"""The humanoid's physics against what a bystander, a spring balance and a stopwatch would say."""

import numpy as np
import pytest

from lbr.errors import InputError
from lbr.messages.joints import KeyFrame
from lbr.simulation.humanoid.settings import Motor, Mounting
from lbr.simulation.measured import ServoDrive
from lbr.simulation.requests import HandRequest
from lbr.simulation.settings import Imu
from tests.simulation.humanoid_bench import TICK_S, Player, drives, humanoid, rows

QUIET = Imu(gyro_bias_rps=(0, 0, 0), gyro_noise_rps=0, accel_bias_mps2=(0, 0, 0), accel_noise_mps2=0)
NO_LOAD_RPS = 6.2
CROUCHED = KeyFrame(
    duration_s=1.0,
    positions={
        f"{side}_{joint}": angle
        for side in ("left", "right")
        for joint, angle in (("hip_pitch", 0.5), ("knee", -1.0), ("ankle_pitch", 0.5))
    },
)


def place(engine, body):
    """Where a part is, seen from the trunk that hangs upright."""
    engine.step({}, 0.0)
    return engine.data.body(body).xpos - engine.data.body("trunk").xpos


def hung(pose, seconds=1.5, **more):
    engine = humanoid(stand=True)
    engine.step(drives(pose, **more), seconds)
    return engine


def test_limp_it_stays_in_the_hand_and_with_torque_it_stands_by_itself():
    engine = humanoid()
    engine.step({}, 2.0)
    limp = engine.pose()
    assert (limp.held, limp.upright) == (True, True)
    engine.step(drives({}), 0.9)
    assert engine.held
    engine.step(drives({}), 4.0)
    alone = engine.pose()
    assert (alone.held, alone.upright) == (False, True)
    assert alone.on_floor == ("left_foot", "right_foot")
    assert abs(alone.pitch_rad) < 0.05


def test_one_servo_without_torque_keeps_the_hand():
    some = drives({})
    del some[13]
    engine = humanoid()
    engine.step(some, 3.0)
    assert engine.held


def test_without_torque_it_falls_and_is_put_back_on_its_feet():
    player = Player()
    player.go((CROUCHED,))
    engine = player.engine
    engine.step({}, 3.0)
    fallen = engine.pose()
    assert not fallen.held
    assert fallen.z_m < 0.2
    engine.pick_up()
    assert (engine.pose().upright, engine.held) == (True, True)
    engine.step(drives({}), 3.0)
    back = engine.pose()
    assert (back.upright, back.held) == (True, False)


def test_who_is_picked_up_looks_where_it_looked():
    player = Player()
    player.play("turn_left", 4)
    looked = player.engine.pose().yaw_rad
    player.go((CROUCHED,))
    player.engine.step({}, 3.0)
    assert not player.engine.pose().upright
    player.engine.pick_up()
    player.engine.step(drives({}), 1.0)
    pose = player.engine.pose()
    assert (pose.held, pose.upright) == (False, True)
    assert pose.yaw_rad == pytest.approx(looked, abs=0.4)


def test_the_hand_keeps_what_would_fall_and_goes_along_with_the_legs():
    lunge = {f"{side}_hip_pitch": 0.5 for side in ("left", "right")}
    engine = humanoid()
    engine.step(drives(lunge), 3.0)
    assert engine.held, "its feet are far ahead of its weight"
    engine.step(drives(CROUCHED.positions), 3.0)
    low = engine.pose()
    assert (low.held, low.upright) == (False, True)
    assert low.z_m < 0.275


def test_on_a_stand_no_foot_reaches_the_floor_and_it_is_never_let_go():
    pose = hung({}, 3.0).pose()
    assert (pose.held, pose.on_floor) == (True, ())


@pytest.mark.parametrize(
    ("joint", "angle", "part", "way"),
    [
        ("shoulder_pitch", 0.8, "forearm", "ahead"),
        ("shoulder_roll", 0.8, "forearm", "outwards"),
        ("elbow", -0.8, "forearm", ""),
        ("hip_pitch", 0.6, "shin", "ahead"),
        ("knee", -0.8, "ankle", "back"),
        ("hip_roll", 0.3, "foot", "outwards"),
    ],
)
def test_angles_count_as_people_say_and_alike_on_both_sides(joint, angle, part, way):
    still, moved = hung({}), hung({f"{side}_{joint}": angle for side in ("left", "right")})
    left, right = (place(moved, f"{side}_{part}") - place(still, f"{side}_{part}") for side in ("left", "right"))
    assert right == pytest.approx(left * [1, -1, 1], abs=2e-3)
    ahead, leftward, up = left
    assert {"ahead": ahead > 0.03, "back": ahead < -0.03, "outwards": leftward > 0.03, "": True}[way]
    assert up > -1e-3, "away from straight is shorter"


def test_toes_go_up_soles_follow_the_hip_and_elbows_bend_inwards():
    engine = hung({"left_ankle_pitch": 0.3, "right_ankle_roll": 0.2, "left_shoulder_roll": 0.9, "left_elbow": -1.5})
    toes = engine.data.body("left_foot").xmat.reshape(3, 3)[:, 0]
    assert toes[2] == pytest.approx(np.sin(0.3), abs=0.02)
    sole = engine.data.body("right_foot").xmat.reshape(3, 3)[:, 2]
    assert sole[1] == pytest.approx(np.sin(0.2), abs=0.02), "its outer edge rises"
    forearm = engine.data.body("left_forearm").xmat.reshape(3, 3)[:, 2]
    assert forearm[1] == pytest.approx(np.sin(1.5 - 0.9), abs=0.1), "the hand is nearer the middle than the elbow"


def test_a_servo_measures_by_its_own_sign_and_zero():
    joints = {joint.name: joint for joint in rows()[0]}
    felt = hung({"left_shoulder_pitch": 1.2, "right_shoulder_pitch": 1.2}).felt()
    for name in ("left_shoulder_pitch", "right_shoulder_pitch"):
        joint = joints[name]
        assert felt[joint.device_id].position_rad == pytest.approx(joint.zero_rad + joint.sign * 1.2, abs=0.06)
        assert joint.sign * felt[joint.device_id].load > 0.03, "it holds the arm up"


def test_a_speed_is_kept_and_the_motor_has_a_fastest():
    engine = humanoid(stand=True)
    seen = {}
    for speed in (0.5, None):
        way = drives({"left_shoulder_pitch": 2.4}, speed_rps=speed)
        fastest = 0.0
        for _ in range(60):
            engine.step(way, TICK_S)
            fastest = max(fastest, abs(engine.felt()[2].speed_rps))
        seen[speed] = fastest
    assert seen[0.5] == pytest.approx(0.5, rel=0.3)
    assert 3.0 < seen[None] < NO_LOAD_RPS


def test_torque_is_limited_to_its_fraction():
    raised = {"left_shoulder_roll": 1.2}
    weak = hung(raised, torque=0.04)
    assert abs(weak.felt()[4].load) <= 0.045
    assert weak.pose().joints["left_shoulder_roll"] < 0.8
    assert hung(raised).pose().joints["left_shoulder_roll"] == pytest.approx(1.2, abs=0.05)


def test_soft_servos_give_way_more_and_within_the_margin_not_at_all():
    raised = {"left_shoulder_roll": 1.2}
    hard, soft = (hung(raised, slopes_rad=(slope, slope)).pose().joints["left_shoulder_roll"] for slope in (0.04, 0.6))
    assert 1.2 - soft > 2 * (1.2 - hard) > 0
    idle = hung({"left_hip_yaw": 0.05}, margins_rad=(0.1, 0.1))
    assert idle.felt()[8].load == pytest.approx(0.0, abs=1e-6)
    assert idle.pose().joints["left_hip_yaw"] == pytest.approx(0.0, abs=1e-3)


def test_the_supply_sags_under_load():
    rested, strained = humanoid(stand=True), humanoid(stand=True)
    rested.step({}, 1.0)
    strained.step(drives(dict.fromkeys(("left_shoulder_roll", "right_shoulder_roll"), 1.2)), 0.3)
    assert strained.sensed().battery_v < rested.sensed().battery_v < 12.1


def test_the_inertial_unit_feels_gravity_up_and_which_way_the_trunk_turns():
    engine = humanoid(stand=True, imu=QUIET)
    engine.step({}, 0.5)
    assert engine.imu().accel_mps2 == pytest.approx((0, 0, 9.81), abs=0.1)
    falling = Player(humanoid(hand_s=0.0, imu=QUIET))
    turned = 0.0
    for _ in range(100):
        falling.engine.step(drives({"left_hip_pitch": 0.6, "right_hip_pitch": 0.6}), TICK_S)
        turned += falling.engine.imu().gyro_rps[1] * TICK_S
    assert turned > 0.4, "it pitches forward"
    assert falling.engine.pose().pitch_rad > 0.4


def test_the_same_steps_with_the_same_seed_give_the_same_run():
    runs = []
    for _ in range(2):
        engine = humanoid(seed=5, motor=Motor(friction_nm=0.05))
        for tick in range(100):
            engine.step(drives({"left_shoulder_pitch": tick / 100}), TICK_S)
        runs.append((engine.pose(), engine.imu(), engine.felt()))
    assert runs[0] == runs[1]


@pytest.mark.parametrize("seed", [1, 2])
def test_whatever_its_servos_are_told_it_stays_of_this_world(seed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo would write its warnings there
    random, engine = np.random.default_rng(seed), Player().engine
    for _ in range(40):
        told = {
            number: ServoDrive(
                goal_rad=random.uniform(-2.6, 2.6),
                torque=random.uniform(-0.2, 1.0),
                slopes_rad=(0.0103, 0.0103),
                margins_rad=(0.0, 0.0),
            )
            for number in range(1, 19)
        }
        engine.step(told, 0.1)
        pose = engine.pose()
        assert np.isfinite([*pose.joints.values(), pose.x_m, pose.y_m, pose.yaw_rad]).all()
        assert 0.0 < pose.z_m < 0.6
    assert not list(tmp_path.iterdir())


def test_a_servo_may_sit_otherwise_than_its_row_says():
    rest = humanoid(stand=True).felt()[2]
    engine = humanoid(stand=True, mounted={"left_shoulder_pitch": Mounting(zero_rad=0.5, sign=1)})
    engine.step({}, 1.0)
    turned = engine.felt()[2]
    assert engine.pose().joints["left_shoulder_pitch"] == pytest.approx(0.0, abs=0.2)
    assert turned.position_rad == pytest.approx(0.5, abs=0.2)
    assert abs(turned.position_rad - rest.position_rad) > 0.5
    with pytest.raises(InputError, match="`mounted`: there is no joint 'nose'"):
        humanoid(mounted={"nose": Mounting()})


def test_a_hand_moves_a_joint_without_torque_and_leaves_it():
    engine = humanoid(stand=True)
    assert "left_elbow at -40" in engine.grip.take(HandRequest(joint="left_elbow", angle_deg=-40.0))
    engine.step({}, 2.0)
    assert engine.pose().joints["left_elbow"] == pytest.approx(-0.698, abs=0.05)
    assert engine.grip.take(HandRequest(gone=True)) == "the hand is gone"
    engine.step(drives({}), 2.0)
    assert engine.pose().joints["left_elbow"] == pytest.approx(0.0, abs=0.1)
    with pytest.raises(InputError, match="there is no joint 'nose'"):
        engine.grip.take(HandRequest(joint="nose"))
