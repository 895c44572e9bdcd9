"""A JointTrajectory as key frames of the robot's joints, or the reason of a refusal. Pure."""

from collections.abc import Collection, Sequence
from itertools import chain, pairwise
from math import isfinite
from typing import Any, NamedTuple

from lbr.apps.ros2 import codec
from lbr.messages.codes import Reason
from lbr.messages.joints import MAX_FRAMES, KeyFrame

TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"


class Way(NamedTuple):
    """Key frames, or the `trouble` with them, and the time in the header, or None."""

    frames: tuple[KeyFrame, ...]
    trouble: Reason | None
    made_ns: int | None

    @property
    def rests(self) -> bool:
        """Return whether it is empty, which is a rest."""
        return not self.frames and self.trouble is None


def trajectory(data: bytes, known: Collection[str]) -> Way:
    """Decode a JointTrajectory of the `known` joints; raise InputError for other bytes."""
    message = codec.decode(TRAJECTORY, data)
    names, points = message.joint_names, message.points
    trouble = (_unfit(names, points, known) or _untimely(points)) if names or points else None
    frames = tuple(_frames(names, points)) if trouble is None else ()
    return Way(frames, trouble, codec.nanoseconds(message.header.stamp) or None)


def _unfit(names: Sequence[str], points: Sequence[Any], known: Collection[str]) -> Reason | None:
    unknown = next((name for name in names if name not in known), None)
    if unknown is not None:
        return Reason("unknown_name", f"there is no joint '{unknown[:40]}'")
    if not names or not points:
        return Reason("bad_value", f"its trajectory has no {'points' if names else 'joints'}")
    if len(set(names)) < len(names):
        return Reason("bad_value", "its trajectory names a joint twice")
    if len(points) > MAX_FRAMES:
        return Reason("bad_value", f"its trajectory has {len(points)} points, and {MAX_FRAMES} are the most")
    if any(len(point.positions) != len(names) for point in points):
        return Reason("bad_value", "a point of its trajectory has not one position for each joint")
    numbers = chain.from_iterable((one.positions, one.velocities, one.accelerations, one.effort) for one in points)
    finite = all(isfinite(number) for several in numbers for number in several)
    return None if finite else Reason("bad_value", "its trajectory has a value that is not a number")


def _untimely(points: Sequence[Any]) -> Reason | None:
    """Return why the times of a trajectory are refused. A first point at 0 is its start, and needs no motion."""
    times_ns = [codec.nanoseconds(point.time_from_start) for point in points]
    rise = times_ns[0] >= 0 and all(before < after for before, after in pairwise(times_ns))
    return None if rise and times_ns[-1] > 0 else Reason("bad_value", "the times of its trajectory do not rise")


def _frames(names: Sequence[str], points: Sequence[Any]) -> Collection[KeyFrame]:
    frames, before_ns = [], 0
    for point in points:
        at_ns = codec.nanoseconds(point.time_from_start)
        if at_ns > 0:
            positions = dict(zip(names, map(float, point.positions), strict=True))
            frames.append(KeyFrame(positions=positions, duration_s=(at_ns - before_ns) / codec.S_NS))
        before_ns = at_ns
    return frames
