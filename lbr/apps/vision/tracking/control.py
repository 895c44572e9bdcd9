"""The head's next aim, from a picture and the head's posture when it was taken. Pure.

Yaw is positive to the left, pitch is positive downwards (REP 103), and the camera looks where the head does. A target
is a direction relative to the body, not a place in the picture. So a late picture is as good as a new one, and the head
does not oscillate.
"""

from dataclasses import dataclass
from math import cos, hypot, inf, isfinite
from typing import NamedTuple

from lbr.apps.vision.direction import Angles, direction, radius_rad
from lbr.messages.tracking import Seen

NEAREST_RAD = 0.02
"""The deviation that is near enough for any target: a servo's count is 0.0185 rad."""
AHEAD = Angles(0.0, 0.0)


class Pose(NamedTuple):
    """The head's posture at a time, its possible error, and its offset from the goal at rest."""

    angles: Angles
    unsure_rad: float
    beside: Angles = AHEAD


@dataclass(frozen=True, slots=True)
class Tuning:
    """The parameters of following; limits are those of the head's joints, the lower one first."""

    yaw_limits: tuple[float, float]
    pitch_limits: tuple[float, float]
    field_rad: float
    dead_zone: float
    gain: float


def follow(aim: Angles, head: Pose, seen: Seen, tuning: Tuning) -> Angles:
    """Return the next aim after `aim`.

    A difference that may come from the head's own movement moves nothing. No step passes the target, which is reached
    from one side. If the head rests beside its aim, the offset is added.
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
    """Return an aim that is `step_rad` nearer to straight ahead."""
    away = hypot(*aim)
    share = max(0.0, 1.0 - step_rad / away) if away > 0.0 else 0.0
    return clamped(Angles(aim.yaw_rad * share, aim.pitch_rad * share), tuning)


def clamped(angles: Angles, tuning: Tuning) -> Angles:
    """Return the nearest angles within the joints' limits."""
    return Angles(_within(angles.yaw_rad, tuning.yaw_limits), _within(angles.pitch_rad, tuning.pitch_limits))


def _within(value: float, limits: tuple[float, float]) -> float:
    return min(max(value, limits[0]), limits[1])
