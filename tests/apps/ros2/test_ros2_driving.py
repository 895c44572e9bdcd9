"""Which twist is followed, in time that a test counts: who drives, what ends it, and what does not go on by itself."""

from math import inf, nan

import pytest

from lbr.messages.codes import Reason
from tests.support import needs

needs.modules("rosbags")
needs.modules("xxhash")
from lbr.apps.ros2 import codec  # noqa: E402 - it needs both
from lbr.apps.ros2.codec import Stamped  # noqa: E402
from lbr.apps.ros2.driving import MOST_PUBLISHERS, Driving, Limits, MotionMessage  # noqa: E402
from lbr.apps.ros2.trajectory import TRAJECTORY, trajectory  # noqa: E402
from lbr.apps.ros2.wire import Attachment  # noqa: E402

LIMITS = Limits(speed_mps=0.5, turn_rps=1.0, silent_s=0.25, late_s=0.4)
ONE, OTHER = b"1" * 16, b"2" * 16
WALL_S = 1_700_000_000.0
AHEAD, REST = (0.2, 0.0, 0.1), (0.0, 0.0, 0.0)
JOINTS = ("left_knee", "right_knee")


def way(points=(), names=JOINTS, **fields):
    """Return a trajectory as it is received: of seconds and angles, with anything else that a point may have."""
    made = [
        {"positions": list(angles), "time_from_start": codec.stamp(round(at_s * 1e9)), **fields}
        for at_s, angles in points
    ]
    return trajectory(codec.encode(TRAJECTORY, {"joint_names": list(names), "points": made}), JOINTS)


THERE, EMPTY = way([(0.0, (0.0, 0.0)), (1.0, (0.5, 0.1)), (1.5, (0.2, 0.3))]), way(names=())


class Side:
    """Publishers in ROS, whose clocks may differ, and what the robot makes of them."""

    def __init__(self, denied=None):
        self.driving = Driving(LIMITS, denied)
        self.now = 100.0
        self.sequence = 0

    def say(self, twist=AHEAD, gid=ONE, *, motion=None, late_s=0.0, clock_s=0.0, made_s=None, sequence=None):
        self.sequence += 1
        sent_ns = round((WALL_S + self.now - late_s + clock_s) * 1e9)
        made_ns = None if made_s is None else sent_ns + round(made_s * 1e9)
        by = Attachment(self.sequence if sequence is None else sequence, sent_ns, gid)
        motion = Stamped(*twist, made_ns) if motion is None else motion._replace(made_ns=made_ns)
        self.driving.receive(MotionMessage(motion, by, self.now, round((WALL_S + self.now) * 1e9)))

    def run(self, seconds, twist=AHEAD, gid=ONE, **how):
        for _ in range(round(seconds / 0.05)):
            self.say(twist, gid, **how)
            self.now += 0.05

    @property
    def twist(self):
        found = self.driving.command(self.now, 0.3)
        return None if found is None else (found.vx_mps, found.vy_mps, found.wz_rps)

    @property
    def codes(self):
        return [why.code for _, why in self.driving.lost]


@pytest.fixture
def side():
    return Side()


def test_a_publisher_drives_until_it_rests(side):
    side.run(1.0)
    assert side.twist == AHEAD
    side.say(REST)
    assert side.twist is None
    assert side.driving.stands.code == "idle"
    side.say()
    assert side.twist == AHEAD
    assert side.codes == []


@pytest.mark.parametrize(
    ("first", "after_s", "drives"), [(2, 0.0, False), (900, 4.9, False), (1, 0.0, True), (0, 0.0, True), (2, 5.1, True)]
)
def test_who_has_published_while_the_bridge_was_away_must_rest_first_and_no_other(side, first, after_s, drives):
    side.driving.joined_s = side.now
    side.now += after_s
    side.sequence = first - 1
    side.run(1.0)
    assert side.twist == (AHEAD if drives else None)
    assert side.codes == ([] if drives else ["rest_first"])
    side.say(REST)
    side.say()
    assert side.twist == AHEAD


def test_a_twist_beyond_the_limits_is_scaled_down_as_a_whole(side):
    side.say((2.0, 0.0, 1.0))
    assert side.twist == pytest.approx((0.5, 0.0, 0.25))
    side.say((0.1, 0.0, 4.0))
    assert side.twist == pytest.approx((0.025, 0.0, 1.0))


def test_silence_ends_it_and_it_goes_on_only_after_rest(side):
    side.run(0.5)
    side.now += 0.21
    assert side.twist is None
    assert side.driving.stands.code == "holder_gone"
    side.run(2.0)
    assert side.twist is None
    assert side.codes == ["holder_gone", "rest_first"]
    side.say(REST)
    side.say()
    assert side.twist == AHEAD


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ({"twist": (nan, 0.0, 0.0)}, "bad_value"),
        ({"twist": (0.2, 0.0, inf)}, "bad_value"),
        ({"late_s": 0.5}, "late"),
        ({"made_s": -0.5}, "late"),
        ({"made_s": -1e9}, "late"),
        ({"made_s": 0.5}, "late"),
    ],
)
def test_what_cannot_be_meant_stops_at_once_is_told_once_and_nothing_resumes(side, message, code):
    side.run(0.5)
    side.say(**message)
    assert side.twist is None
    side.run(1.0, **message)
    side.run(1.0)
    assert side.twist is None
    assert side.codes == [code, "rest_first"]
    side.say(REST)
    side.say()
    assert side.twist == AHEAD


def test_a_rest_that_comes_late_counts_for_nothing(side):
    side.run(0.5)
    side.say(late_s=1.0)
    side.say(REST, late_s=1.0)
    side.say()
    assert side.twist is None


def test_a_clock_that_differs_is_measured_and_does_not_make_late(side):
    side.run(1.0, clock_s=-3600.0)
    assert side.twist == AHEAD
    side.say(clock_s=-3600.0, late_s=0.5)
    assert side.twist is None


def test_a_stamp_of_now_in_the_senders_own_clock_is_followed(side):
    side.run(1.0, clock_s=1e6, made_s=-0.02)
    assert side.twist == AHEAD


def test_what_comes_twice_or_out_of_order_is_not_followed_and_silence_ends_it(side):
    side.run(0.5)
    last = side.sequence
    side.run(0.3, (0.5, 0.0, 0.0), sequence=last)
    assert side.twist is None
    assert side.codes == ["holder_gone"]


def test_another_publisher_waits_and_is_told_once(side):
    side.run(0.5)
    side.say((-0.2, 0.0, 0.0), OTHER)
    side.say((-0.2, 0.0, 0.0), OTHER)
    side.say(REST, OTHER)
    assert side.twist == AHEAD
    assert side.codes == ["held"]
    side.say(REST)
    side.say((-0.2, 0.0, 0.0), OTHER)
    assert side.twist == (-0.2, 0.0, 0.0)


def test_a_publisher_that_is_gone_and_comes_back_by_its_name_must_rest_first(side):
    side.run(0.5)
    side.driving.leave(ONE, Reason("holder_gone", "it is gone"))
    assert side.twist is None
    side.run(0.5)
    assert side.twist is None
    assert side.codes == ["holder_gone", "rest_first"]
    side.say((0.1, 0.0, 0.0), OTHER)
    assert side.twist == (0.1, 0.0, 0.0)


def test_after_a_stop_or_a_lost_router_all_that_are_there_must_rest_first(side):
    side.run(0.5)
    side.say(REST, OTHER)
    side.driving.end_all(Reason("stopped", "stopped by console"))
    side.run(0.5)
    side.run(0.5, gid=OTHER)
    assert side.twist is None
    assert side.codes == ["stopped", "rest_first", "rest_first"]


def test_who_may_not_drive_is_told_once_and_moves_nothing():
    side = Side(Reason("token", "no token"))
    side.run(1.0)
    assert side.twist is None
    assert side.codes == ["token"]


def test_a_message_that_cannot_be_read_stops_who_drives(side):
    side.run(0.5)
    side.driving.malformed(OTHER, "it is not a Twist")
    assert side.twist == AHEAD
    side.driving.malformed(ONE, "it is not a Twist")
    side.run(0.5)
    assert side.twist is None


def test_any_number_of_publishers_is_bounded(side):
    for number in range(10 * MOST_PUBLISHERS):
        side.say(gid=number.to_bytes(16, "little"))
        side.now += 0.01
    assert len(side.codes) <= 10 * MOST_PUBLISHERS


def test_a_trajectory_is_key_frames_from_its_first_point_after_the_start(side):
    side.say(motion=THERE)
    command = side.driving.command(side.now, 0.3)
    assert [frame.duration_s for frame in command.frames] == [1.0, 0.5]
    assert command.frames[1].positions == {"left_knee": 0.2, "right_knee": 0.3}


def test_a_trajectory_goes_on_in_silence_and_when_it_is_over_the_next_may_begin(side):
    side.say(motion=THERE)
    side.now += 100.0
    assert side.driving.command(side.now, 0.3).frames == THERE.frames
    side.say(gid=OTHER)
    side.driving.finish()
    assert side.driving.command(side.now, 0.3) is None
    side.say(motion=THERE)
    assert side.driving.driver == ONE
    assert side.codes == ["held"]


def test_an_empty_trajectory_ends_one_and_lets_its_publisher_begin_after_an_interruption(side):
    side.say(motion=THERE)
    side.say(motion=EMPTY)
    assert side.driving.stands.code == "idle"
    side.say(motion=THERE)
    side.driving.end_all(Reason("stopped", "stopped by console"))
    side.say(motion=THERE)
    assert side.driving.command(side.now, 0.3) is None
    assert side.codes == ["stopped", "rest_first"]
    side.say(motion=EMPTY)
    side.say(motion=THERE)
    assert side.driving.driver == ONE


@pytest.mark.parametrize(
    ("motion", "code"),
    [
        (way([(1.0, (0.5, 0.1))], names=("left_knee", "tail")), "unknown_name"),
        (way([(1.0, (0.5, 0.1))], names=("left_knee", "left_knee")), "bad_value"),
        (way(), "bad_value"),
        (way([(1.0, ())], names=()), "bad_value"),
        (way([(1.0, (0.5,))]), "bad_value"),
        (way([(1.0, (0.5, nan))]), "bad_value"),
        (way([(1.0, (0.5, 0.1))], velocities=[inf]), "bad_value"),
        (way([(0.0, (0.5, 0.1))]), "bad_value"),
        (way([(1.0, (0.5, 0.1)), (1.0, (0.2, 0.3))]), "bad_value"),
        (way([(-1.0, (0.5, 0.1)), (1.0, (0.2, 0.3))]), "bad_value"),
        (way([(at, (0.5, 0.1)) for at in range(1, 1500)]), "bad_value"),
    ],
)
def test_a_trajectory_that_cannot_be_meant_stops_at_once_and_is_told_once(side, motion, code):
    side.say(motion=THERE)
    side.say(motion=motion)
    side.say(motion=motion)
    side.say(motion=THERE)
    assert side.driving.command(side.now, 0.3) is None
    assert side.codes == [code, "rest_first"]


def test_a_trajectory_with_a_stamp_of_the_past_is_refused(side):
    side.say(motion=THERE, made_s=-0.5)
    assert side.driving.command(side.now, 0.3) is None
    assert side.codes == ["late"]
