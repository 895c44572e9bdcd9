"""The direction and apparent size of a target in a picture. Pure.

Yaw is positive to the left, pitch is positive downwards (REP 103).
"""

from math import atan, atan2, cos, hypot, sin, tan
from typing import NamedTuple

from lbr.messages.tracking import Seen


class Angles(NamedTuple):
    """The direction of a camera, or of a thing."""

    yaw_rad: float
    pitch_rad: float


def direction(camera: Angles, seen: Seen, field_rad: float) -> Angles:
    """Return the direction of a target: the angles of a camera that has it in the middle."""
    scale = 2.0 * tan(field_rad / 2.0)
    left, up = -seen.x * scale, -seen.y * scale
    ahead = cos(camera.pitch_rad) + sin(camera.pitch_rad) * up
    above = cos(camera.pitch_rad) * up - sin(camera.pitch_rad)
    return Angles(camera.yaw_rad + atan2(left, ahead), atan2(-above, hypot(ahead, left)))


def radius_rad(seen: Seen, field_rad: float) -> float:
    """Return the apparent size of a target: the angle from its middle to its rim."""
    return atan(seen.radius * 2.0 * tan(field_rad / 2.0))
