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


def part_of(joint: Joint) -> str:
    return joint.name.removeprefix(f"{joint.side}_")


def makes_room(joint: Joint) -> dict[str, float]:
    """What else has to move before a joint can go inwards."""
    other = {"left": "right", "right": "left"}.get(joint.side, "")
    angles, _ = ASIDE.get(part_of(joint), ({}, ""))
    return {f"{other if part_of(joint) == 'hip_roll' else joint.side}_{name}": angle for name, angle in angles.items()}


def reaches(robot: str, limits: dict[str, float], room: dict[str, float]) -> None:
    if room:
        goes_to(robot, room)
    reached = goes_to(robot, {**room, **limits})
    assert {name: reached[name] for name in limits} == pytest.approx(limits, abs=NEAR_RAD)
    if room:
        goes_to(robot, room)
        goes_to(robot, {})


@pytest.mark.parametrize(
    ("robot", "part"), [(robot, part) for robot in ROBOTS for part in dict.fromkeys(map(part_of, known(robot)[0]))]
)
def test_the_joints_of_both_sides_reach_both_limits_of_their_rows(robot, part):
    joints = [joint for joint in hung(robot)[1].values() if part_of(joint) == part]
    for sides in [joints] if part not in ASIDE else [[joint] for joint in joints]:
        reaches(robot, {joint.name: joint.lower_rad for joint in sides}, makes_room(sides[0]))
        reaches(robot, {joint.name: joint.upper_rad for joint in sides}, {})
        goes_to(robot, {})


@pytest.mark.parametrize(
    ("robot", "name", "limit"),
    [("bioloid", "left_elbow", -1.93), ("uxa90", "left_shoulder_roll", -0.481), ("uxa90", "left_hip_roll", -0.352)],
)
def test_what_is_in_the_way_of_a_joint_stops_it(robot, name, limit):
    goes_to(robot, {})
    assert goes_to(robot, {name: limit})[name] > limit + NEAR_RAD
    goes_to(robot, {})
