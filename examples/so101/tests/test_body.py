"""The body: lengths and masses as published, and arms that fall without torque."""

import sqlite3

import pytest
from lbr_so101.robot import ROBOT

from lbr.messages.joints import Joint
from lbr.resources import robot_db_sql
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.servos import servo
from lbr.simulation.humanoid.settings import HumanoidWorldSettings, Motor
from lbr.simulation.measured import ServoDrive
from lbr.simulation.physics import mujoco
from lbr.simulation.requests import HandRequest

ARM = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")
MOTOR = Motor(stall_nm=2.94, no_load_rps=5.2, friction_nm=0.052, armature_kgm2=0.028, stall_a=2.7)


@pytest.fixture(scope="module")
def joints():
    database = sqlite3.connect(":memory:")
    database.executescript(robot_db_sql().read_text() + ROBOT.rows.read_text())
    fields = Joint.__struct_fields__
    found = database.execute(f"SELECT {', '.join(fields)} FROM joint WHERE robot = 'so101' ORDER BY name").fetchall()
    database.close()
    return tuple(Joint(**dict(zip(fields, row, strict=True))) for row in found)


@pytest.mark.parametrize(
    ("pose", "tip_m"),
    [
        ((0, 0, 0, 0, 0, 0), (0.3914, 0.0, 0.2265)),
        ((0.5, 0, 0, 0, 0, 0), (0.3482, -0.1690, 0.2265)),
        ((0, 0, 0.5, 0, 0, 0), (0.3541, 0.0, 0.0858)),
        ((0, 0, 0, 0.5, 0, 0), (0.3681, 0.0, 0.1511)),
        ((0.3, -0.4, 0.5, 0.6, -0.7, 0.8), (0.2935, -0.0735, 0.1158)),
    ],
)
@pytest.mark.parametrize("prefix", ["", "leader_"])
def test_the_tip_is_where_the_published_description_has_it(prefix, pose, tip_m):
    model = mujoco.MjModel.from_xml_path(str(ROBOT.body))
    data = mujoco.MjData(model)
    for name, angle in zip(ARM, pose, strict=True):
        data.joint(prefix + name).qpos[0] = angle
    mujoco.mj_kinematics(model, data)
    assert data.site(f"{prefix}tip").xpos - data.body(f"{prefix}base").xpos == pytest.approx(tip_m, abs=2e-4)
    assert model.body_subtreemass[model.body(f"{prefix}base").id] == pytest.approx(0.632)


def driven(joints, pose, bus):
    return {
        servo(joint.bus, joint.device_id): ServoDrive(goal_rad=pose.get(joint.name, 0.0), torque=1.0)
        for joint in joints
        if joint.bus == bus
    }


def tip_m(engine, name="tip"):
    return float(engine._data.site(name).xpos[2])


def test_an_arm_holds_with_torque_and_falls_without_and_the_other_is_another(joints):
    engine = HumanoidEngine(HumanoidWorldSettings(model="so101", motor=MOTOR, rests={"elbow_flex": 0.1}), joints, "")
    raised = driven(joints, {"shoulder_lift": -0.6}, "follower_bus")
    engine.step(raised, 3.0)
    pose = engine.pose()
    assert pose.joints["shoulder_lift"] == pytest.approx(-0.6, abs=0.05)
    assert pose.joints["leader_shoulder_lift"] > 0.5, "the leader has no torque and fell"
    held_m = tip_m(engine)
    engine.step({}, 3.0)
    assert tip_m(engine) < held_m - 0.1
    assert engine.pose().upright


def test_a_hand_moves_a_limp_arm_and_leaves_it(joints):
    engine = HumanoidEngine(HumanoidWorldSettings(model="so101", motor=MOTOR), joints, "")
    shown = {"leader_shoulder_pan": 40.0, "leader_shoulder_lift": -30.0, "leader_elbow_flex": 0.0}
    for name, angle in shown.items():
        engine.grip.take(HandRequest(joint=name, angle_deg=angle))
    engine.step({}, 3.0)
    pose = engine.pose().joints
    assert [pose[name] for name in shown] == pytest.approx([0.698, -0.524, 0.0], abs=0.05)
    held_m = tip_m(engine, "leader_tip")
    engine.grip.take(HandRequest(gone=True))
    engine.step({}, 3.0)
    assert tip_m(engine, "leader_tip") < held_m - 0.03
