"""The head's posture at a past time, from the recent reports of its joints. Pure.

A joint without measurements is assumed at its last goal, or somewhat behind it.
"""

from bisect import bisect_left
from math import inf, isfinite
from typing import NamedTuple

from lbr.apps.vision.direction import Angles
from lbr.apps.vision.tracking.control import Pose
from lbr.messages.joints import JointState

KEPT_S = 3.0
SLACK_S = 0.1
"""The possible difference between the times of a picture and of a measurement with the same date."""
LAG_S = 0.3
"""The greatest lag of a joint behind its goal."""
CURRENT_S = 0.5
"""The age before a picture at which a measurement no longer counts for it."""
SETTLED_S = 0.6
MOST_BESIDE_RAD = 0.3
REST_RAD = 0.03
"""The spread that counts as rest: a measurement may alternate between two counts."""


class Line:
    """A value over time, linear between its samples."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._values: list[float] = []

    @property
    def newest_s(self) -> float:
        """Return the time of the last value; minus infinity before the first."""
        return self._times[-1] if self._times else -inf

    def add(self, at_s: float, value: float) -> None:
        """Add a value; one that is not newer than the last is ignored."""
        if not (isfinite(at_s) and isfinite(value) and at_s > self.newest_s):
            return
        self._times.append(at_s)
        self._values.append(value)
        old = bisect_left(self._times, at_s - KEPT_S)
        del self._times[:old], self._values[:old]

    def at(self, at_s: float) -> float:
        """Return the value at a time, constant outside the samples. There must be one."""
        after = bisect_left(self._times, at_s)
        if after == 0:
            return self._values[0]
        if after == len(self._times):
            return self._values[-1]
        share = (at_s - self._times[after - 1]) / (self._times[after] - self._times[after - 1])
        return self._values[after - 1] + share * (self._values[after] - self._values[after - 1])

    def spread(self, from_s: float, to_s: float) -> float:
        """Return the range of the value between two times."""
        if not self._times:
            return 0.0
        inner = self._values[bisect_left(self._times, from_s) : bisect_left(self._times, to_s)]
        values = (self.at(from_s), *inner, self.at(to_s))
        return max(values) - min(values)


class _Where(NamedTuple):
    """The position of one joint at a time."""

    rad: float
    unsure_rad: float
    beside_rad: float


class JointPast:
    """The recent reports of one joint: its measured positions and its goals."""

    def __init__(self) -> None:
        self._measured, self._goals = Line(), Line()
        self._beside_rad = 0.0

    def add(self, state: JointState, sent_s: float) -> None:
        """Add a state of the joint."""
        if state.position_rad is not None:
            self._measured.add(sent_s - (state.age_s or 0.0), state.position_rad)
        if state.goal_rad is not None:
            self._goals.add(sent_s, state.goal_rad)

    def at(self, taken_s: float) -> _Where | None:
        """Return the position at a time; None if unknown."""
        goals, measured = self._goals, self._measured
        if taken_s - measured.newest_s < CURRENT_S:
            unsure = measured.spread(taken_s - SLACK_S, taken_s + SLACK_S)
            if measured.newest_s < taken_s + SLACK_S:
                unsure += goals.spread(measured.newest_s - SLACK_S, taken_s + SLACK_S)
            self._rest(taken_s, unsure)
            return _Where(measured.at(taken_s), unsure, self._beside_rad)
        if goals.newest_s == -inf:
            return None
        return _Where(goals.at(taken_s), goals.spread(taken_s - LAG_S, taken_s + SLACK_S), 0.0)

    def _rest(self, taken_s: float, unsure_rad: float) -> None:
        """Learn the joint's offset from its goal at rest, such as by the weight of the head."""
        spread_rad = self._goals.spread(taken_s - SETTLED_S, taken_s + SLACK_S)
        if unsure_rad < REST_RAD and spread_rad < REST_RAD and self._goals.newest_s > -inf:
            beside = self._measured.at(taken_s) - self._goals.at(taken_s)
            self._beside_rad = min(max(beside, -MOST_BESIDE_RAD), MOST_BESIDE_RAD)


class Gaze:
    """The postures of the head's two joints."""

    def __init__(self) -> None:
        self._yaw, self._pitch = JointPast(), JointPast()

    def add(self, yaw: JointState | None, pitch: JointState | None, sent_s: float) -> None:
        """Add states of both joints."""
        for past, state in ((self._yaw, yaw), (self._pitch, pitch)):
            if state is not None:
                past.add(state, sent_s)

    def at(self, taken_s: float) -> Pose | None:
        """Return the head's posture at a time; None if unknown."""
        yaw, pitch = self._yaw.at(taken_s), self._pitch.at(taken_s)
        if yaw is None or pitch is None:
            return None
        beside = Angles(yaw.beside_rad, pitch.beside_rad)
        return Pose(Angles(yaw.rad, pitch.rad), yaw.unsure_rad + pitch.unsure_rad, beside)
