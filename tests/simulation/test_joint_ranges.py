"""Hung up, each joint of the simulated humanoids goes as far as its row allows, both ways."""

from functools import cache

import pytest

from tests.support import needs

needs.modules("mujoco")

from msgspec.structs import replace  # noqa: E402

from lbr.messages.joints import Joint  # noqa: E402
from lbr.simulation.humanoid.engine import HumanoidEngine  # noqa: E402
from lbr.simulation.measured import ServoDrive  # noqa: E402
from tests.models.feet import known  # noqa: E402

NEAR_RAD = 0.05
"""The UXA-90's stops are up to 0.04 rad within its rows, on which it sits."""
SWINGS_S, HANGS_M = 1.2, 0.3
ROBOTS = ("bioloid", "uxa90")
ASIDE = {
    "hip_roll": ({"hip_roll": 0.3}, "the other leg is in its way"),
    "shoulder_roll": ({"shoulder_pitch": 1.4}, "an arm that hangs meets its own thigh"),
    "elbow": ({"shoulder_pitch": 1.4}, "a forearm that hangs folds into its own trunk"),
}
"""Of what goes inwards, which joints of the other leg, or of the same arm, make room for it, and why."""


@cache
def hung(robot: str) -> tuple[HumanoidEngine, dict[str, Joint]]:
    """A robot of the rows in the air, and its joints by name."""
    joints, _, settings = known(robot)
    engine = HumanoidEngine(replace(settings, rests={}, stand=True), joints, "/nonexistent")
    engine.data.mocap_pos[0, 2] += HANGS_M
    return engine, {joint.name: joint for joint in joints}


def goes_to(robot: str, pose: dict[str, float]) -> dict[str, float]:
    """Where the joints are once their servos have been told a pose; all others go to zero."""
    engine, joints = hung(robot)
    drives = {
        joint.device_id: ServoDrive(goal_rad=joint.zero_rad + joint.sign * pose.get(name, 0.0), torque=1.0)
        for name, joint in joints.items()
    }
    engine.step(drives, SWINGS_S)
    return engine.pose().joints


def makes_room(joint: Joint) -> dict[str, float]:
    """What else has to move before a joint can go inwards."""
    side, _, part = joint.name.partition("_")
    other = {"left": "right", "right": "left"}.get(side, "")
    angles, _ = ASIDE.get(part, ({}, ""))
    return {f"{other if part == 'hip_roll' else side}_{name}": angle for name, angle in angles.items()}


@pytest.mark.parametrize(("robot", "name"), [(robot, joint.name) for robot in ROBOTS for joint in known(robot)[0]])
def test_a_joint_reaches_both_limits_of_its_row(robot, name):
    joint = hung(robot)[1][name]
    for limit in (joint.lower_rad, joint.upper_rad):
        room = makes_room(joint) if limit < 0.0 else {}
        if room:
            goes_to(robot, room)
        assert goes_to(robot, {**room, name: limit})[name] == pytest.approx(limit, abs=NEAR_RAD)
        if room:
            goes_to(robot, room)
        goes_to(robot, {})


@pytest.mark.parametrize(
    ("robot", "name", "limit"),
    [("bioloid", "left_elbow", -1.93), ("uxa90", "left_shoulder_roll", -0.481), ("uxa90", "left_hip_roll", -0.352)],
)
def test_what_is_in_the_way_of_a_joint_stops_it(robot, name, limit):
    goes_to(robot, {})
    assert goes_to(robot, {name: limit})[name] > limit + NEAR_RAD
    goes_to(robot, {})
