from math import inf, isfinite, nan, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.vision.direction import Angles, direction, radius_rad
from lbr.apps.vision.tracking.control import (
    AHEAD,
    NEAREST_RAD,
    Pose,
    Tuning,
    ahead_again,
    follow,
)
from lbr.apps.vision.tracking.gaze import Gaze, Line
from lbr.messages.joints import JointState
from lbr.messages.tracking import Seen
from tests.apps.vision.tracking_bench import FIELD_RAD, Head, away_rad, project

TUNING = Tuning(yaw_limits=(-2.3, 2.3), pitch_limits=(-0.83, 0.92), field_rad=FIELD_RAD, dead_zone=0.75, gain=0.5)
small = st.floats(-0.4, 0.4)
angles = st.builds(Angles, st.floats(-1.5, 1.5), st.floats(-0.7, 0.7))
anything = st.floats(allow_nan=True, allow_infinity=True)


@given(head=angles, yaw=small, pitch=st.floats(-0.3, 0.3))
def test_a_direction_is_found_from_wherever_the_head_looks(head, yaw, pitch):
    target = Angles(head.yaw_rad + yaw, head.pitch_rad + pitch)
    seen = project(head, target)
    if seen is not None:
        assert direction(head, seen, FIELD_RAD) == pytest.approx(target, abs=1e-9)


def test_to_the_right_of_the_picture_is_a_turn_to_the_right_and_below_is_down():
    aim = follow(AHEAD, Pose(AHEAD, 0.0), Seen(x=0.3, y=0.2, radius=0.02), TUNING)
    assert aim.yaw_rad < -0.1
    assert aim.pitch_rad > 0.05


def test_in_the_dead_zone_nothing_moves():
    seen = Seen(x=0.7 * 0.1, y=0.0, radius=0.1)
    assert follow(AHEAD, Pose(AHEAD, 0.0), seen, TUNING) == AHEAD
    assert follow(AHEAD, Pose(AHEAD, 0.0), Seen(x=0.8 * 0.1, y=0.0, radius=0.1), TUNING) != AHEAD


@given(
    aim=angles,
    head=st.builds(Pose, st.builds(Angles, anything, anything), anything, st.builds(Angles, anything, anything)),
    seen=st.builds(Seen, x=anything, y=anything, radius=anything),
)
def test_whatever_comes_what_leaves_is_finite_and_within_the_limits(aim, head, seen):
    found = follow(aim, head, seen, TUNING)
    assert all(isfinite(value) for value in found)
    assert TUNING.yaw_limits[0] <= found.yaw_rad <= TUNING.yaw_limits[1]
    assert TUNING.pitch_limits[0] <= found.pitch_rad <= TUNING.pitch_limits[1]


def test_what_is_beyond_the_limits_is_looked_at_as_far_as_it_goes():
    aim = Angles(2.2, 0.0)
    for _ in range(20):
        aim = follow(aim, Pose(aim, 0.0), project(aim, Angles(2.6, 0.0)), TUNING)
    assert aim.yaw_rad == pytest.approx(2.3, abs=0.05)


def test_ahead_again_is_slow_and_ends_ahead():
    aim = Angles(1.0, 0.5)
    way = [aim := ahead_again(aim, 0.1, TUNING) for _ in range(20)]
    assert way[0] == pytest.approx((0.9106, 0.4553), abs=1e-3)
    assert way[-1] == AHEAD


def test_a_line_remembers_where_it_was_and_how_far_it_went():
    line = Line()
    for at, value in ((1.0, 0.0), (1.1, 1.0), (1.2, 0.5), (1.15, 9.0), (inf, 1.0), (1.3, nan)):
        line.add(at, value)
    assert (line.at(0.0), line.at(1.05), line.at(9.0)) == pytest.approx((0.0, 0.5, 0.5))
    assert line.spread(1.05, 1.15) == pytest.approx(0.5)
    assert line.spread(1.0, 2.0) == 1.0


def test_nobody_knows_where_a_head_looks_that_was_never_measured_nor_told():
    gaze = Gaze()
    gaze.add(JointState(id=23), JointState(id=24, position_rad=0.1), 1.0)
    assert gaze.at(1.0) is None


class Watching:
    """A head, its joints' states at some rate, pictures that come late, and the aims that follow."""

    def __init__(self, head, target, *, trusted, fps, told_hz, late_s, wrong_s, joint_late_s):
        self.head, self.target = head, target
        self.trusted = trusted
        self.every, self.tell_every = 1.0 / fps, 1.0 / told_hz
        self.late_s, self.wrong_s, self.joint_late_s = late_s, wrong_s, joint_late_s
        self.gaze = Gaze()
        self.aim = Angles(*head.angles)
        self.aims = []
        self.pictures, self.states = [], []
        self.shot = self.told = 0.0

    def run(self, seconds):
        for _ in range(round(seconds / Head.TICK_S)):
            self.head.tick()
            now = self.head.now
            if now >= self.told:
                self.told = now + self.tell_every
                self.states.append((now, self.head.angles, self.head.goal))
            if now >= self.shot:
                self.shot = now + self.every
                self.pictures.append((now, project(self.head.angles, self.target)))
            while self.states and self.states[0][0] + self.joint_late_s <= now:
                at, measured, goal = self.states.pop(0)
                states = [
                    JointState(id=n, position_rad=measured[n] if self.trusted else None, goal_rad=goal[n], age_s=0.0)
                    for n in (0, 1)
                ]
                self.gaze.add(*states, at)
            while self.pictures and self.pictures[0][0] + self.late_s <= now:
                at, seen = self.pictures.pop(0)
                pose = self.gaze.at(at + self.wrong_s)
                if seen is not None and pose is not None:
                    self.aim = follow(self.aim, pose, seen, TUNING)
                    self.head.aim(self.aim)
            self.aims.append(self.aim)


heads = st.builds(
    Head,
    st.floats(-0.5, 0.5),
    st.floats(-0.3, 0.3),
    delay_s=st.floats(0.0, 0.15),
    lag_s=st.floats(0.02, 0.1),
    speed_rps=st.floats(0.5, 4.0),
)


@given(
    head=heads,
    yaw=st.floats(-0.45, 0.45),
    pitch=st.floats(-0.3, 0.3),
    trusted=st.booleans(),
    fps=st.sampled_from((10.0, 15.0, 30.0)),
    told_hz=st.sampled_from((5.0, 20.0, 50.0)),
    late_s=st.floats(0.0, 0.2),
    wrong_s=st.floats(-0.08, 0.08),
    joint_late_s=st.floats(0.0, 0.05),
)
def test_with_all_delays_the_head_comes_to_the_ball_from_one_side_and_rests(
    head, yaw, pitch, trusted, fps, told_hz, late_s, wrong_s, joint_late_s
):
    target = Angles(head.angles.yaw_rad + yaw, head.angles.pitch_rad + pitch)
    late = {"late_s": late_s, "wrong_s": wrong_s, "joint_late_s": joint_late_s}
    watching = Watching(head, target, trusted=trusted, fps=fps, told_hz=told_hz, **late)
    watching.run(6.0)
    seen = project(head.angles, target)
    if project(Angles(target.yaw_rad - yaw, target.pitch_rad - pitch), target) is None:
        return  # it never was in the picture
    enough = max(NEAREST_RAD, 0.75 * radius_rad(seen, FIELD_RAD))
    assert away_rad(seen) <= enough + 0.01
    assert len(set(watching.aims[-200:])) == 1, "it still hunts after five seconds"
    for axis in (0, 1):
        beyond = [
            (aim[axis] - target[axis]) * (1 if target[axis] >= watching.aims[0][axis] else -1) for aim in watching.aims
        ]
        assert max(beyond) <= enough + 0.01, "it went past the ball"


def test_a_head_that_rests_beside_its_aim_is_asked_for_more():
    head = Head(error_rad=-0.1)
    watching = Watching(
        head, Angles(0.3, 0.1), trusted=True, fps=15, told_hz=20, late_s=0.1, wrong_s=0.0, joint_late_s=0.01
    )
    watching.run(10.0)
    assert away_rad(project(head.angles, watching.target)) <= radians(2.3)
    assert len(set(watching.aims[-200:])) == 1


def test_a_ball_that_goes_by_is_followed():
    head = Head()
    watching = Watching(
        head, Angles(0.0, 0.1), trusted=True, fps=15, told_hz=20, late_s=0.1, wrong_s=0.0, joint_late_s=0.01
    )
    for step in range(100):
        watching.target = Angles(0.01 * step, 0.1)
        watching.run(0.03)
        assert project(head.angles, watching.target) is not None, f"lost at {watching.target}"
