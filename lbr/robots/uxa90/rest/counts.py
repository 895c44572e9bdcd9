"""Conversion between counts of a SAM servo, the API's positions, and angles of the robot's joints."""

from math import ceil, degrees, floor

from lbr.messages.joints import Joint
from lbr.robots.uxa90.driver.messages import COUNT_RAD, HIGHEST, LOWEST, MIDDLE

STRONGEST, WEAKEST = 0, 4
_SLACK = 1e-6


def joint_rad(joint: Joint, count: float) -> float:
    """Return the joint's angle at a count of its servo."""
    return joint.sign * ((count - MIDDLE) * COUNT_RAD - joint.zero_rad)


def count_of(joint: Joint, angle_rad: float) -> float:
    """Return the servo's count at an angle of its joint, not rounded."""
    return MIDDLE + (joint.zero_rad + joint.sign * angle_rad) / COUNT_RAD


def allowed(joint: Joint) -> tuple[int, int]:
    """Return the lowest and the highest count that the joint's limits and the line allow."""
    ends = sorted((count_of(joint, joint.lower_rad), count_of(joint, joint.upper_rad)))
    return max(LOWEST, ceil(ends[0] - _SLACK)), min(HIGHEST, floor(ends[1] + _SLACK))


def strength(level: int) -> float:
    """Return the fraction of torque for a level: 0 is the strongest, 4 the weakest."""
    return round(1.0 - 0.2 * level, 3)


def in_degrees(joint: Joint, count: float) -> float:
    """Return the joint's angle in degrees, to a tenth."""
    return round(degrees(joint_rad(joint, count)), 1)
