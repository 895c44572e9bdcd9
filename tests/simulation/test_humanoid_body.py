"""Bodies for the humanoid world: the one that is shipped, one of one's own, and what is said of one that does not fit."""

import pytest

from lbr.errors import InputError
from lbr.simulation.humanoid.body import load, model_file
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from tests.simulation.humanoid_bench import humanoid, rows

ONE = """<mujoco><worldbody><body name="trunk" pos="0 0 0.2"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/>
<site name="imu"/>{inside}</body>{beside}</worldbody></mujoco>"""
JOINT = '<body name="{name}"><joint name="{name}" {more}/><geom type="sphere" size=".02" mass=".1"/></body>'


def made(tmp_path, text):
    (tmp_path / "models").mkdir(exist_ok=True)
    path = tmp_path / "models" / "mine.xml"
    path.write_text(text)
    return path


def refusal(path, names):
    joints = [joint for joint in rows()[0] if joint.name in names]
    with pytest.raises(InputError) as told:
        load(path, joints, HumanoidWorldSettings(model="mine"))
    return str(told.value)


def test_the_shipped_body_is_as_tall_and_heavy_as_the_kit():
    body = humanoid().body
    assert sum(body.model.body_mass) == pytest.approx(1.7, abs=0.1)
    assert sorted(body.feet) == ["left_foot", "right_foot"]
    assert len(body.positions) == 18


def test_a_body_of_ones_own_goes_before_the_shipped_one_and_unknown_ones_are_listed(tmp_path):
    path = made(tmp_path, "")
    assert model_file("mine", str(tmp_path)) == path
    assert model_file("bioloid", str(tmp_path)).is_file()
    with pytest.raises(InputError, match=r"no body 'other'.*there are: bioloid, mine"):
        model_file("other", str(tmp_path))
    path.with_name("bioloid.xml").write_text("")
    assert model_file("bioloid", str(tmp_path)).parent == path.parent


def test_missing_and_unknown_joints_are_named(tmp_path, wording):
    path = made(tmp_path, ONE.format(inside=JOINT.format(name="left_tail", more=""), beside=""))
    told = refusal(path, {"left_knee"})
    wording(told)


def test_a_joint_that_is_no_hinge_is_named(tmp_path):
    path = made(tmp_path, ONE.format(inside=JOINT.format(name="left_knee", more='type="slide"'), beside=""))
    assert "the joint 'left_knee' is not a hinge" in refusal(path, {"left_knee"})


def test_a_joint_whose_range_was_written_in_the_other_unit_is_named_with_what_to_write(tmp_path):
    def body(head):
        text = ONE.format(inside=JOINT.format(name="left_knee", more='range="-1.6 1.6"'), beside="")
        return made(tmp_path, text.replace("<mujoco>", f"<mujoco>{head}"))

    told = refusal(body(""), {"left_knee"})
    assert "the joint 'left_knee' turns from -0.028 to 0.028 rad, and its row says" in told
    assert 'angle="radian"' in told
    joints = [joint for joint in rows()[0] if joint.name == "left_knee"]
    assert load(body('<compiler angle="radian"/>'), joints, HumanoidWorldSettings(model="mine"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<mujoco><worldbody>", "Line number=1"),
        ('<mujoco><worldbody><body nme="x"/></worldbody></mujoco>', "unrecognized attribute: 'nme'"),
        ("", "empty"),
        ("\x00\xff", "Line number"),
        (ONE.format(inside="", beside="<body/>"), "one body at the top"),
        (ONE.replace("<freejoint/>", "").format(inside="", beside=""), "freejoint"),
        (ONE.replace('name="imu"', "").format(inside="", beside=""), '<site name="imu"/>'),
        (ONE.replace('mass="1"', 'mass="-1"').format(inside="", beside=""), "mass"),
    ],
)
def test_a_file_that_is_no_body_is_refused_by_its_name_and_place(tmp_path, text, said):
    path = made(tmp_path, text)
    told = refusal(path, set())
    assert str(path) in told
    assert said in told
