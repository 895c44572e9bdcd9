"""Postures of the UXA-90: joints in radians, legs by where their feet are, and how its servos count that."""

from functools import cache
from math import acos, atan2, cos, hypot, sin
from typing import Any

from lbr.robots.uxa90.twin.firmware import Frame
from lbr.robots.uxa90.twin.servo import as_counts, as_rad
from lbr.simulation.physics import mujoco
from tests.models.uxa90.robot import humanoid, joints, settings

Pose = dict[str, float]
Point = tuple[float, float, float]

SIDES = (("left", 1), ("right", -1))
HIP_M, SHANK_M = 0.057, 0.21
"""Half the distance between the hips, and the length of a thigh as of a shin."""

HEIGHT_M, LEAN_RAD, WEIGHT_M = 0.385, 0.04, 0.035
"""Walking: the hips above the ankles, how the trunk leans ahead, and how far ahead of the ankles the weight is."""

_BASIC_COUNTS = (
    *(125, 127, 102, 150, 89, 166, 146, 109, 127, 127, 127, 127),
    *(63, 191, 137, 117, 131, 123, 174, 80, 127, 127, 127, 127, 127),
)
"""The factory's walking stance."""

STRAIGHT: Pose = {joint.name: 0.0 for joint in joints()}
BASIC: Pose = {joint.name: joint.sign * (as_rad(_BASIC_COUNTS[joint.device_id]) - joint.zero_rad) for joint in joints()}
SITTING: Pose = {**STRAIGHT, **settings().rests}
_LEGS = ("hip", "knee", "ankle")
ARMS: Pose = {name: angle for name, angle in BASIC.items() if not any(part in name for part in _LEGS)}
"""All but the legs, as in the walking stance."""


def frame(pose: Pose, duration_s: float, *, smooth: bool = True) -> Frame:
    """Return a key frame of a posture."""
    servos = {joint.name: joint for joint in joints()}
    counts = {
        str(servos[name].device_id): round(as_counts(servos[name].zero_rad + servos[name].sign * angle), 1)
        for name, angle in pose.items()
    }
    return Frame(duration_s=duration_s, counts=counts, smooth=smooth)


def leg(side: str, ankle: Point, lean_rad: float, yaw_rad: float = 0.0) -> Pose:
    """Return a leg whose foot is flat, its ankle ahead of, outside of and above its hip, its toes turned outward."""
    x, y, z = ankle
    x, z = x * cos(lean_rad) - z * sin(lean_rad), x * sin(lean_rad) + z * cos(lean_rad)
    x, y = x * cos(yaw_rad) + y * sin(yaw_rad), y * cos(yaw_rad) - x * sin(yaw_rad)
    roll, down = atan2(y, -z), hypot(y, z)
    bend = 2 * acos(min(0.99999, hypot(x, down) / (2 * SHANK_M)))
    pitch = atan2(x, down) + bend / 2
    return {
        f"{side}_hip_yaw": yaw_rad,
        f"{side}_hip_roll": roll,
        f"{side}_hip_pitch": pitch,
        f"{side}_knee": -bend,
        f"{side}_ankle_pitch": lean_rad - pitch + bend,
        f"{side}_ankle_roll": -roll,
    }


@cache
def hips_ahead_m(height_m: float, lean_rad: float, weight_m: float) -> float:
    """Return how far the hips have to be ahead of the ankles for the weight to be where it should."""
    low, high = -0.2, 0.2
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (low, middle) if _weight_ahead_m(middle, height_m, lean_rad) > weight_m else (middle, high)
    return (low + high) / 2


def legs(
    sway_m: float = 0.0,
    height_m: float = HEIGHT_M,
    lean_rad: float = LEAN_RAD,
    *,
    right: Point = (0.0, 0.0, 0.0),
) -> Pose:
    """Return legs with the hips swayed to the left, and the right foot elsewhere than on the floor below its hip."""
    ahead_m = hips_ahead_m(height_m, lean_rad, WEIGHT_M)
    return {
        **leg("left", (-ahead_m, -sway_m, -height_m), lean_rad),
        **leg("right", (right[0] - ahead_m, right[1] + sway_m, right[2] - height_m), lean_rad),
    }


@cache
def _body() -> tuple[Any, Any, int]:
    body = humanoid().body
    return body.model, mujoco.MjData(body.model), body.trunk


def _weight_ahead_m(hips_m: float, height_m: float, lean_rad: float) -> float:
    """Return how far its weight is ahead of its ankles, as MuJoCo has it."""
    model, data, trunk = _body()
    ankle = (-hips_m, 0.0, -height_m)
    for name, angle in {**ARMS, **leg("left", ankle, lean_rad), **leg("right", ankle, lean_rad)}.items():
        data.qpos[model.joint(name).qposadr[0]] = angle
    data.qpos[3:7] = (cos(lean_rad / 2), 0.0, sin(lean_rad / 2), 0.0)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return float(data.subtree_com[trunk][0] - data.body("left_ankle").xpos[0])
