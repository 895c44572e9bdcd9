"""Ways of joints through key frames: smooth or straight, never beyond their frames, never faster than allowed."""

from bisect import bisect_right
from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise
from math import copysign

import msgspec
from msgspec import Struct

from lbr.messages.joints import Interpolation, KeyFrame

SHORTEST_S = 0.01
"""The least time of a way, even to the present position."""
SLACK = 1e-9
STEEPEST = 3.0
"""A cubic stays between its ends while its slopes are at most this many times the straight line's (Fritsch, Carlson).
"""

Slopes = tuple[float, ...]


class Trajectory(Struct, frozen=True, kw_only=True):
    """Positions of joints over time, in seconds from the start; radians and radians a second.

    `slopes` are the speeds at the knots; a joint that has none goes straight. `stretch` is the factor by which it is
    slower than requested, because of `slowest`. `stable` are the knots at which the robot may come to rest.
    """

    times_s: tuple[float, ...]
    knots: Mapping[str, tuple[float, ...]]
    slopes: Mapping[str, Slopes] = {}
    stretch: float = 1.0
    slowest: str = ""
    stable: frozenset[int] = frozenset()

    @property
    def duration_s(self) -> float:
        """Return the total time."""
        return self.times_s[-1]

    @property
    def targets(self) -> dict[str, float]:
        """Return the final positions."""
        return {name: values[-1] for name, values in self.knots.items()}


def plan(
    start: Mapping[str, float],
    frames: Sequence[KeyFrame],
    limits_rps: Mapping[str, float],
    interpolation: Interpolation = "smooth",
    speeds_rps: Mapping[str, float] | None = None,
) -> Trajectory:
    """Return the way from `start` through every frame; a joint that a frame leaves out stays.

    All of it is stretched alike, so that no joint is faster than its limit. A smooth way begins at the joint's present
    speed (`speeds_rps`, unless it is stretched) and ends at rest. In between it stops only where it turns back.
    """
    names = [name for name in start if any(name in frame.positions for frame in frames)]
    knots = {name: _knots(start[name], name, frames) for name in names}
    steps_s = [max(SHORTEST_S, frame.duration_s) for frame in frames]
    slopes: dict[str, Slopes] = {}
    if interpolation == "smooth":
        begun = speeds_rps or {}
        slopes = {name: _slopes(values, steps_s, begun.get(name, 0.0)) for name, values in knots.items()}
    ratio, name = _too_fast(knots, slopes, steps_s, limits_rps)
    stretch = max(1.0, ratio)
    return Trajectory(
        times_s=_times([step_s * stretch for step_s in steps_s]),
        knots=knots,
        slopes={joint: tuple(slope / stretch for slope in values) for joint, values in slopes.items()},
        stretch=stretch,
        slowest=name if stretch > 1.0 + SLACK else "",
        stable=frozenset(at for at, frame in enumerate(frames, 1) if frame.stable),
    )


def positions(trajectory: Trajectory, elapsed_s: float) -> dict[str, float]:
    """Return the positions of its joints at a time; before its start and after its end they stand."""
    return {name: position for name, (position, _) in _states(trajectory, elapsed_s).items()}


def speeds(trajectory: Trajectory, elapsed_s: float) -> dict[str, float]:
    """Return the speeds of its joints at a time; 0 before its start and after its end."""
    if elapsed_s < 0.0:
        return dict.fromkeys(trajectory.knots, 0.0)
    return {name: speed for name, (_, speed) in _states(trajectory, elapsed_s).items()}


def passed(trajectory: Trajectory, elapsed_s: float) -> int:
    """Return the number of passed key frames."""
    return max(0, bisect_right(trajectory.times_s, elapsed_s) - 1)


def ahead(trajectory: Trajectory, elapsed_s: float) -> tuple[KeyFrame, ...]:
    """Return the key frames ahead, each with its remaining time."""
    first = passed(trajectory, elapsed_s) + 1
    times_s = (elapsed_s, *trajectory.times_s[first:])
    return tuple(
        KeyFrame(
            positions={name: values[at] for name, values in trajectory.knots.items()},
            duration_s=end_s - begin_s,
            stable=at in trajectory.stable,
        )
        for at, (begin_s, end_s) in enumerate(pairwise(times_s), first)
    )


def without(trajectory: Trajectory, names: Collection[str]) -> Trajectory | None:
    """Return the way without some joints, the others unchanged; None if no joint is left."""
    knots = {name: values for name, values in trajectory.knots.items() if name not in names}
    return msgspec.structs.replace(trajectory, knots=knots) if knots else None


def _states(trajectory: Trajectory, elapsed_s: float) -> dict[str, tuple[float, float]]:
    times_s = trajectory.times_s
    if not elapsed_s < times_s[-1]:  # this way round, NaN is the end
        return {name: (values[-1], 0.0) for name, values in trajectory.knots.items()}
    at = max(0, bisect_right(times_s, elapsed_s) - 1)
    step_s = times_s[at + 1] - times_s[at]
    share = min(1.0, max(0.0, (elapsed_s - times_s[at]) / step_s))
    return {name: _within(trajectory, name, at, share, step_s) for name in trajectory.knots}


def _within(trajectory: Trajectory, name: str, at: int, share: float, step_s: float) -> tuple[float, float]:
    """Return position and speed at a share of a step; a cubic is bounded against rounding."""
    values = trajectory.knots[name]
    begin, end = values[at], values[at + 1]
    way, slopes = end - begin, trajectory.slopes.get(name)
    if slopes is None or way == 0.0:
        position, speed = begin + way * share, way / step_s
    else:
        first, last = slopes[at] * step_s, slopes[at + 1] * step_s
        square, cube = 3.0 * way - 2.0 * first - last, first + last - 2.0 * way
        position = begin + share * (first + share * (square + share * cube))
        speed = (first + share * (2.0 * square + 3.0 * share * cube)) / step_s
    return min(max(position, min(begin, end)), max(begin, end)), speed


def _knots(start: float, name: str, frames: Sequence[KeyFrame]) -> tuple[float, ...]:
    values = [start]
    for frame in frames:
        values.append(frame.positions.get(name, values[-1]))
    return tuple(values)


def _times(steps_s: Sequence[float]) -> tuple[float, ...]:
    times_s = [0.0]
    for step_s in steps_s:
        times_s.append(times_s[-1] + step_s)
    return tuple(times_s)


def _slopes(values: Sequence[float], steps_s: Sequence[float], begun_rps: float) -> Slopes:
    """Return the speed at each knot: the weighted harmonic mean of both sides, 0 where the way turns (PCHIP)."""
    lines = [(end - begin) / step_s for (begin, end), step_s in zip(pairwise(values), steps_s, strict=True)]
    inner = [
        (before_s + after_s) * 3.0 / ((2.0 * after_s + before_s) / before + (after_s + 2.0 * before_s) / after)
        if before * after > 0.0
        else 0.0
        for (before, after), (before_s, after_s) in zip(pairwise(lines), pairwise(steps_s), strict=True)
    ]
    forward = begun_rps * lines[0] > 0.0
    first = copysign(min(abs(begun_rps), STEEPEST * abs(lines[0])), begun_rps) if forward else 0.0
    return (first, *inner, 0.0)


def _too_fast(
    knots: Mapping[str, Sequence[float]],
    slopes: Mapping[str, Slopes],
    steps_s: Sequence[float],
    limits_rps: Mapping[str, float],
) -> tuple[float, str]:
    """Return the factor by which the worst joint is too fast, and its name."""
    ratios = ((_fastest(values, slopes.get(name), steps_s) / limits_rps[name], name) for name, values in knots.items())
    return max(ratios, default=(0.0, ""))


def _fastest(values: Sequence[float], slopes: Slopes | None, steps_s: Sequence[float]) -> float:
    """Return the greatest speed on the way: at a knot, or where a cubic is steepest."""
    fastest = 0.0
    for at, step_s in enumerate(steps_s):
        line = (values[at + 1] - values[at]) / step_s
        if slopes is None:
            fastest = max(fastest, abs(line))
        elif line != 0.0:
            first, last = slopes[at], slopes[at + 1]
            fastest = max(fastest, abs(first), abs(last), _steepest(line, first, last))
    return fastest


def _steepest(line: float, first: float, last: float) -> float:
    """Return the speed at the vertex of a cubic's derivative, if that lies between its ends."""
    bend = 3.0 * (first + last - 2.0 * line)
    share = (2.0 * first + last - 3.0 * line) / bend if bend else -1.0
    return abs(first - bend * share * share) if 0.0 < share < 1.0 else 0.0
