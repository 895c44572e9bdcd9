"""A robot's body as data: what is exported moves and looks as the simulated body does."""

import random
from math import cos, sin
from pathlib import Path

import msgspec
import pytest

from lbr.apps.bodies import mjcf, wheeled
from lbr.apps.bodies.model import body_file, model
from lbr.apps.bodies.parts import Body, RobotModel
from lbr.apps.bodies.turning import NO_TURN, Place, about, by_euler, product, rotated, rpy
from lbr.errors import InputError
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor, ring
from lbr.robot import registry

HERE = Path(__file__).resolve().parents[3]
BODIES = {
    "bioloid": HERE / "lbr/robots/bioloid/body.xml",
    "uxa90": HERE / "lbr/robots/uxa90/body.xml",
    "so101": HERE / "examples/so101/lbr_so101/body.xml",
}
NEAR_M = 1e-3

ODD = """
<mujoco>
  <compiler angle="degree" eulerseq="zyx"/>
  <default>
    <geom rgba="0.1 0.2 0.3 1"/>
    <default class="thin"><geom type="capsule" size="0.01 0.05"/><joint axis="0 1 0"/></default>
  </default>
  <asset><material name="red" rgba="1 0 0 1"/></asset>
  <worldbody>
    <geom name="bench" type="box" size="0.2 0.3 0.05" pos="0 0 0.05" zaxis="1 2 3"/>
    <body name="a" pos="0.1 0.2 0.3" euler="10 20 30" childclass="thin">
      <joint name="one" pos="0.01 0.02 0.03" axis="1 1 0"/>
      <joint name="two" ref="25"/>
      <joint name="three" type="slide" axis="0 0 2" ref="0.02" pos="0.3 0 0"/>
      <geom fromto="0 0 0 0.1 0.2 -0.3" size="0.02"/>
      <geom type="box" fromto="0 0 0.1 -0.1 0.2 0.3" size="0.02" material="red"/>
      <frame pos="0.1 0 0" axisangle="0 1 0 40">
        <geom type="ellipsoid" size="0.1 0.2 0.3" quat="1 2 3 4"/>
        <body name="b" pos="0 0 0.1" xyaxes="0 1 0 -1 0 1">
          <joint name="four" pos="0 0.1 0" axis="0 0 1" class="main"/>
          <geom type="sphere" size="0.1" rgba="0 1 0 0.5"/>
          <geom type="cylinder" size="0.1 0.2" euler="0 90 0" group="1"/>
        </body>
      </frame>
    </body>
  </worldbody>
</mujoco>
"""


def placed(body: Body, angles: dict[str, float]) -> dict[str, Place]:
    """Where each link lies when its joints have these angles: what a page does, in a few lines."""
    found: dict[str, Place] = {"": Place()}
    for link in body.links:
        at = Place(link.origin_xyz, by_euler(link.origin_rpy, "XYZ"))
        value = angles.get(link.joint, 0.0)
        slides = body.joints.get(link.joint) == "slide"
        x, y, z = link.axis
        own = Place((x * value, y * value, z * value)) if slides else Place(turn=about(link.axis, value))
        found[link.name] = found[link.parent].then(at).then(own)
    return found


def agrees(body: Body, spec) -> None:
    """Compare with MuJoCo, in a few random poses, where bodies are and where each shape's corners are."""
    np, mujoco = pytest.importorskip("numpy"), pytest.importorskip("mujoco")
    compiled = spec.compile()
    data, dice = mujoco.MjData(compiled), random.Random(4)
    for _ in range(5):
        angles = {}
        for name in body.joints:
            joint = compiled.joint(name)
            low, high = joint.range if compiled.jnt_limited[joint.id] else (-2.0, 2.0)
            angles[name] = dice.uniform(float(low), float(high))
            data.qpos[joint.qposadr[0]] = angles[name]
        mujoco.mj_kinematics(compiled, data)
        links = placed(body, angles)
        for at in range(1, compiled.nbody):
            there = links[compiled.body(at).name]
            assert np.linalg.norm(data.xpos[at] - there.xyz) < NEAR_M, compiled.body(at).name
        geoms = iter(range(compiled.ngeom))
        for link in body.links:
            for shape in link.shapes:
                geom = next(geoms)
                there = links[link.name].then(Place(shape.xyz, by_euler(shape.rpy, "XYZ")))
                assert np.linalg.norm(data.geom_xpos[geom] - there.xyz) < NEAR_M
                ours = [rotated(there.turn, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
                assert np.abs(data.geom_xmat[geom].reshape(3, 3).T - np.array(ours)).max() < 1e-4
                assert list(shape.rgba) == pytest.approx(compiled.geom_rgba[geom].tolist(), abs=1e-6)
        assert next(geoms, None) is None


@pytest.mark.parametrize("robot", BODIES)
def test_the_exported_body_moves_as_the_simulated_one(robot):
    mujoco = pytest.importorskip("mujoco")
    path = BODIES[robot]
    agrees(mjcf.read(path), mujoco.MjSpec.from_file(str(path)))


def test_all_that_a_description_may_say_of_places_and_turns_is_read_as_mujoco_reads_it():
    mujoco = pytest.importorskip("mujoco")
    body = mjcf.parse(ODD)
    agrees(body, mujoco.MjSpec.from_string(ODD))
    assert body.joints == {"one": "hinge", "two": "hinge", "three": "slide", "four": "hinge"}
    assert body.left_out == ()


def test_a_body_needs_no_physics_engine():
    body = mjcf.read(BODIES["bioloid"])
    assert len(body.joints) == 18
    assert {"left_foot", "right_foot"} <= {link.name for link in body.links}
    assert [one.kind for one in body.sensors] == ["imu"]
    assert mjcf.read(BODIES["uxa90"]).sensors[-1].kind == "camera"


def test_a_camera_looks_along_the_x_of_its_axes():
    head = next(one for one in mjcf.read(BODIES["uxa90"]).sensors if one.name == "head")
    assert rotated(by_euler(head.rpy, "XYZ"), (1.0, 0.0, 0.0)) == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)


def test_the_zero_pose_stands_on_the_floor():
    body = mjcf.read(BODIES["bioloid"])
    links = placed(body, {})
    soles = [
        links[link.name].xyz[2] + s.xyz[2] - s.size[2] / 2
        for link in body.links
        if "foot" in link.name
        for s in link.shapes
    ]
    assert min(soles) == pytest.approx(0.0, abs=1e-3)


def test_what_is_no_simple_shape_is_left_out_and_said():
    text = ODD.replace("<worldbody>", '<worldbody><geom type="plane" size="1 1 1"/><include file="x.xml"/>')
    text = text.replace('<geom type="sphere"', '<geom type="mesh" mesh="m"/><joint type="ball"/><geom type="sphere"')
    said = mjcf.parse(text).left_out
    assert said == ("1 shape of type plane", "1 <include>", "1 joint of type ball", "1 shape of type mesh")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no XML"),
        ("<mujoco/>", "worldbody"),
        ("<robot><worldbody/></robot>", "no MJCF"),
        (ODD.replace('pos="0.1 0.2 0.3"', 'pos="0.1 0.2"'), "cannot be read"),
        (ODD.replace('pos="0.1 0.2 0.3"', 'pos="a b c"'), "could not convert"),
        (ODD.replace('axis="1 1 0"', 'axis="0 0 0"'), "no length"),
        (ODD.replace('size="0.1 0.2 0.3"', 'size="0.1"'), "needs 3 sizes"),
        (ODD.replace('childclass="thin"', 'childclass="none"'), "no default class 'none'"),
        (ODD.replace("0.1 0.2 0.3", "nan 0 0", 1), "nan"),
    ],
)
def test_what_is_no_body_is_refused_in_words(text, said):
    with pytest.raises(InputError, match=said):
        mjcf.parse(text)


@pytest.mark.parametrize("angles", [(0.3, -1.1, 2.0), (0.0, 1.5707963267948966, 0.7), (3.0, -1.5707963267948966, 1.0)])
def test_roll_pitch_and_yaw_say_the_same_turn(angles):
    turn = by_euler(angles, "XYZ")
    again = by_euler(rpy(turn), "XYZ")
    assert abs(sum(a * b for a, b in zip(turn, again, strict=True))) == pytest.approx(1.0, abs=1e-9)
    assert product(turn, NO_TURN) == turn


def test_a_base_on_wheels_is_where_the_simulated_one_is():
    np, mujoco = pytest.importorskip("numpy"), pytest.importorskip("mujoco")
    from lbr.simulation.model import ROBOT, model_xml
    from lbr.simulation.settings import WorldSettings

    settings = WorldSettings()
    rows = ring(settings.body.length_m, settings.body.width_m)
    body = wheeled.body((), rows)
    compiled = mujoco.MjModel.from_xml_string(model_xml(settings))
    data = mujoco.MjData(compiled)
    mujoco.mj_kinematics(compiled, data)
    links = placed(body, {})
    for name in ("left_wheel", "right_wheel"):
        assert np.linalg.norm(data.body(name).xpos - links[name].xyz) < NEAR_M
    deck = compiled.geom("deck")
    shape = body.links[0].shapes[0]
    assert list(shape.size) == pytest.approx((2 * deck.size).tolist())
    assert data.geom("deck").xpos[2] == pytest.approx(links["base"].then(Place(shape.xyz)).xyz[2])
    assert deck.group[0] == ROBOT
    assert {one.name: one.xyz[:2] for one in body.sensors}["forward"] == (settings.body.length_m / 2, 0.0)


def test_wheels_of_rows_are_where_their_rows_say():
    wheels = [
        Wheel(name=f"{x}{y}", motor=y, x_m=x * 0.13, y_m=0.18 if y == "left" else -0.18, diameter_m=0.15)
        for x in (1, -1)
        for y in ("left", "right")
    ]
    lidar = RangeSensor(name="lidar", kind="lidar", x_m=0.05, z_m=0.3, fov_rad=6.2832, rays=360, max_m=12)
    body = wheeled.body(wheels, [lidar])
    links = placed(body, {})
    assert links["1left_wheel"].xyz == pytest.approx((0.13, 0.18, 0.075))
    assert not [shape for shape in body.links[0].shapes if shape.kind == "sphere"]
    assert body.sensors[0].max_m == 12
    assert links["base"].then(Place(body.sensors[0].xyz)).xyz[2] == pytest.approx(0.3)


@pytest.mark.parametrize("yaw", [0.0, 2.1])
def test_an_omni_wheel_turns_about_its_own_axle(yaw):
    wheel = Wheel(name="w", motor="w", x_m=0.1, yaw_rad=yaw, diameter_m=0.1)
    body = wheeled.body([wheel], [])
    axle = rotated(placed(body, {})["w_wheel"].turn, body.links[1].axis)
    assert axle == pytest.approx((-sin(yaw), cos(yaw), 0.0))


def test_a_model_says_limits_of_rows_and_why_there_is_nothing_to_draw(tmp_path):
    from lbr.messages.joints import Joint

    row = Joint(name="left_elbow", device_id=6, side="left", lower_rad=-1.9, upper_rad=0.1, speed_rps=3.0)
    lone = Joint(name="tail", device_id=7, lower_rad=-1.0, upper_rad=1.0, speed_rps=1.0)
    file = body_file("bioloid", tmp_path)
    assert file == registry.bodies()["bioloid"]
    found = model("bioloid", file, [row, lone], (), ())
    assert (found.joints["left_elbow"].lower, found.joints["left_elbow"].side) == (-1.9, "left")
    assert not found.joints["tail"].drawn
    assert msgspec.json.decode(msgspec.json.encode(found), type=RobotModel) == found
    assert "models/octopus.xml" in model("octopus", body_file("octopus", tmp_path), [row], (), ()).reason
    assert model("lbr", body_file("lbr", tmp_path), (), (), ()).links[0].name == "base"


def test_an_owners_own_body_goes_before_the_packages(tmp_path):
    own = tmp_path / "models" / "bioloid.xml"
    own.parent.mkdir()
    own.write_text("<mujoco>")
    assert body_file("bioloid", tmp_path) == own
    assert str(own) in model("bioloid", own, (), (), ()).reason
