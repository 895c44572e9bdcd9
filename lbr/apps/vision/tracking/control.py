"""Where the head is to look, out of what a picture shows and how the head stood when it was taken. Pure.

Yaw is positive to the left, pitch is positive downwards (REP 103), and the camera looks where the head does. A target
is a direction of the body's, not a place in the picture: so a late picture is as good as a new one, and nothing hunts.
"""

from dataclasses import dataclass
from math import cos, hypot, inf, isfinite
from typing import NamedTuple

from lbr.apps.vision.direction import Angles, direction, radius_rad
from lbr.messages.tracking import Seen

NEAREST_RAD = 0.02
"""Nearer than this is near enough for any target: a servo's count is 0.0185 rad."""
AHEAD = Angles(0.0, 0.0)


class Pose(NamedTuple):
    """The head's posture at a time, its possible error, and its rest beside its goal."""

    angles: Angles
    unsure_rad: float
    beside: Angles = AHEAD


@dataclass(frozen=True, slots=True)
class Tuning:
    """The rules for following with the head; limits are those of its joints, the lower one first."""

    yaw_limits: tuple[float, float]
    pitch_limits: tuple[float, float]
    field_rad: float
    dead_zone: float
    gain: float


def follow(aim: Angles, head: Pose, seen: Seen, tuning: Tuning) -> Angles:
    """Return where to look from now on, who was to look at `aim`.

    A difference that the head's own movement may feign moves nothing, and no step passes the target: it is reached from
    one side. A head that comes to rest beside its aim is asked for so much more.
    """
    if not all(map(isfinite, (*head.angles, *head.beside, head.unsure_rad, seen.x, seen.y, seen.radius))):
        return aim
    target = clamped(direction(head.angles, seen, tuning.field_rad), tuning)
    yaw = target.yaw_rad - head.beside.yaw_rad - aim.yaw_rad
    pitch = target.pitch_rad - head.beside.pitch_rad - aim.pitch_rad
    away = hypot(yaw * cos(target.pitch_rad), pitch)
    enough = max(NEAREST_RAD, tuning.dead_zone * radius_rad(seen, tuning.field_rad))
    if not enough + head.unsure_rad < away < inf:
        return aim
    share = min(tuning.gain, 1.0) * (away - head.unsure_rad) / away
    return clamped(Angles(aim.yaw_rad + share * yaw, aim.pitch_rad + share * pitch), tuning)


def ahead_again(aim: Angles, step_rad: float, tuning: Tuning) -> Angles:
    """Return an aim that is so much nearer to straight ahead."""
    away = hypot(*aim)
    share = max(0.0, 1.0 - step_rad / away) if away > 0.0 else 0.0
    return clamped(Angles(aim.yaw_rad * share, aim.pitch_rad * share), tuning)


def clamped(angles: Angles, tuning: Tuning) -> Angles:
    """Return the nearest that the joints can do."""
    return Angles(_within(angles.yaw_rad, tuning.yaw_limits), _within(angles.pitch_rad, tuning.pitch_limits))


def _within(value: float, limits: tuple[float, float]) -> float:
    return min(max(value, limits[0]), limits[1])
