"""The check of balance: where a body begins, whether it falls, and how far its weight is within what carries it."""

from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support import needs

needs.modules("mujoco")

from lbr.apps.motions.commands.work import done  # noqa: E402
from lbr.errors import InputError  # noqa: E402
from lbr.messages.joints import Joint, KeyFrame, MotionRow, MotionStep, motions_of  # noqa: E402
from lbr.messages.motion_work import Checked, CheckJob  # noqa: E402
from lbr.simulation.humanoid.balance import FALLEN_RAD, hull, margin  # noqa: E402
from tests.support import databases  # noqa: E402

SIT = {"left_hip_pitch": 1.78, "left_knee": -2.4, "left_ankle_pitch": 0.9}
SIT |= {name.replace("left", "right"): angle for name, angle in SIT.items()}
COORDINATES = st.floats(-5.0, 5.0, allow_nan=False)
POINTS = st.lists(st.tuples(COORDINATES, COORDINATES), min_size=1, max_size=12)


def rows(robot, kind):
    return databases.of_robot(robot).of(kind)


def checked(robot, *frames, **more):
    job = CheckJob(robot=robot, home="/nowhere", joints=rows(robot, Joint), frames=frames, **more)
    *_, last = done(job)
    assert isinstance(last, Checked)
    return last.report


def frame(duration_s=1.0, **positions):
    return KeyFrame(positions=positions, duration_s=duration_s)


@pytest.mark.parametrize("start", [{}, SIT], ids=["standing", "sitting"])
def test_a_body_begins_where_it_is_on_its_soles(start):
    report = checked("uxa90", frame(right_elbow=-0.5), start=start)
    assert (report.begins, report.stands) == (True, True)
    assert min(one.margin_mm for one in report.trace) > 20


def test_a_motion_is_judged_from_its_first_key_frame_where_the_robot_does_not_stand_now():
    """Picked up, it has the joints of its fall; the hand that holds it leads it into the motion."""
    standing, fallen = frame(**dict.fromkeys(SIT, 0.0)), {"left_hip_pitch": 1.5, "right_hip_pitch": 1.5}
    report = checked("uxa90", standing, frame(right_elbow=-0.5), start=fallen)
    assert (report.led, report.begins, report.stands, report.falls_s) == (True, True, True, None)
    assert (checked("uxa90", standing, start={}).led, checked("uxa90", standing, start=SIT).led) == (False, False)


def test_of_a_motion_that_does_not_stand_where_it_begins_no_fall_is_told():
    bent = frame(left_hip_pitch=1.5, right_hip_pitch=1.5)
    report = checked("uxa90", bent, start=bent.positions)
    assert (report.stands, report.begins, report.falls_s, report.trace) == (False, False, None, ())


@pytest.mark.parametrize("name", ["sit", "walk_ahead"])
def test_a_motion_that_comes_with_a_robot_leaves_it_upright(name):
    known = {one.name: one for one in motions_of(rows("bioloid", MotionRow), rows("bioloid", MotionStep))}
    motion = known[name]
    report = checked("bioloid", *motion.frames, lead_in=known[motion.lead_in].frames if motion.lead_in else ())
    assert (report.begins, report.falls_s) == (True, None)


def test_a_lead_in_is_played_and_counts_as_no_key_frame():
    report = checked("bioloid", frame(left_elbow=-0.5), frame(left_elbow=-0.2), lead_in=(frame(left_elbow=-1.0),))
    assert [one.frame for one in report.trace] == sorted(one.frame for one in report.trace)
    assert {one.frame for one in report.trace} == {0, 1, 2}


def test_the_trace_ends_soon_after_the_fall():
    report = checked("bioloid", frame(0.5, left_ankle_pitch=0.6, right_ankle_pitch=0.6), frame(30.0, left_elbow=-1.0))
    assert report.falls_s is not None
    assert report.falls_frame == 2
    assert report.trace[-1].t_s < report.falls_s + 2.0
    assert max(one.tilt_rad for one in report.trace if one.t_s < report.falls_s) <= FALLEN_RAD


def test_the_same_motion_has_the_same_report():
    one, other = (checked("bioloid", frame(left_elbow=-0.5, left_hip_roll=0.1)) for _ in range(2))
    assert one.trace == other.trace


def test_a_body_that_is_not_there_is_named():
    frames = (frame(left_elbow=-0.5),)
    job = CheckJob(robot="nobot", home="/nowhere", joints=rows("bioloid", Joint), frames=frames)
    with pytest.raises(InputError, match="there is no body 'nobot'"):
        list(done(job))


@given(POINTS, st.tuples(COORDINATES, COORDINATES))
def test_a_point_is_within_an_outline_by_no_more_than_its_nearest_corner(points, point):
    corners = hull(points)
    assert set(corners) <= set(points)
    found = margin(point, corners)
    assert abs(found) <= min(hypot(point[0] - x, point[1] - y) for x, y in corners) + 1e-9


@given(POINTS)
def test_no_point_is_outside_its_own_outline(points):
    corners = hull(points)
    assert all(margin(point, corners) >= -1e-6 for point in points)


def test_a_square_says_how_far_in_and_out():
    square = hull([(0, 0), (2, 0), (2, 2), (0, 2), (1, 1), (1, 0)])
    assert square == [(0, 0), (2, 0), (2, 2), (0, 2)]
    assert [round(margin(point, square), 3) for point in ((1, 1), (1, 0.25), (1, -0.5), (3, 3))] == [
        1,
        0.25,
        -0.5,
        -1.414,
    ]
