"""Teleoperation by itself: the followed pose, the phases, and the ends."""

from math import inf, isfinite, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lbr_so101.teleop import KIND, TeleopCommand, TeleopSettings
from lbr_so101.teleop.follow import gap_rad, phase_after, pose_of

from lbr.messages.codes import Reason
from lbr.messages.joints import Joint, JointsState, JointState
from lbr.messages.leases import CommandReply, StopCommand
from lbr.testing import FakeCall, FakeContext

JOINTS = tuple(
    Joint(name=name, device_id=number, lower_rad=-1.0, upper_rad=1.0, speed_rps=2.0)
    for number, name in enumerate(("pan", "lift"), 1)
)
SETTINGS = TeleopSettings()


def state(prefix="", age_s=0.01, **places):
    found = {
        f"{prefix}{name}": JointState(id=1, position_rad=at, age_s=None if at is None else age_s)
        for name, at in places.items()
    }
    return JointsState(sequence=1, measured_s=0.0, moving=False, phase="released", joints=found)


def leader(pan=0.1, lift=0.2, **more):
    return state("leader_", pan=pan, lift=lift, **more)


def test_the_pose_is_the_leaders_within_the_followers_limits():
    assert pose_of(leader(pan=0.3, lift=-3.0), 0.0, JOINTS, SETTINGS) == {"pan": 0.3, "lift": -1.0}


@pytest.mark.parametrize(
    ("said", "age_s"),
    [(None, inf), (leader(pan=None), 0.0), (leader(pan=nan), 0.0), (leader(), 0.21), (leader(age_s=0.15), 0.1),
     (leader(age_s=nan), 0.0), (leader(), nan), (leader(lift=inf), 0.0)],
)  # fmt: skip
def test_what_is_old_or_no_number_is_no_pose(said, age_s):
    why = pose_of(said, age_s, JOINTS, SETTINGS)
    assert isinstance(why, Reason)
    assert why.code == "stale_sensor"


@given(st.floats(), st.floats(), st.floats(), st.floats())
def test_whatever_the_leader_says_a_pose_is_of_finite_numbers_within_limits(pan, lift, age_s, older_s):
    pose = pose_of(leader(pan=pan, lift=lift, age_s=age_s), older_s, JOINTS, SETTINGS)
    if not isinstance(pose, Reason):
        assert all(isfinite(at) and -1.0 <= at <= 1.0 for at in pose.values())
        assert age_s + older_s <= SETTINGS.max_age_s


def test_it_follows_from_near_and_approaches_again_from_far():
    assert phase_after("approaching", 0.3, SETTINGS) == "approaching"
    assert phase_after("approaching", 0.1, SETTINGS) == "following"
    assert phase_after("following", 0.3, SETTINGS) == "following"
    assert phase_after("following", 1.1, SETTINGS) == "approaching"
    assert phase_after("following", nan, SETTINGS) == phase_after("following", inf, SETTINGS) == "approaching"
    assert gap_rad({"pan": 0.0}, state(pan=None)) == gap_rad({"pan": 0.0}, None) == inf
    assert gap_rad({"pan": 0.0, "lift": 0.5}, state(pan=0.1, lift=0.1)) == pytest.approx(0.4)


LENT = {"joints": CommandReply(accepted=True, lease="l", goal="g")}
REFUSED = {"joints": CommandReply(accepted=False, reason="the emergency stop is engaged", code="estop")}


class Bench:
    """The capability, with a leader and a follower whose states the test sets, and joints that answer."""

    def __init__(self):
        self.ctx = FakeContext(KIND, SETTINGS, given=JOINTS)
        self.ctx.replies = {"move": LENT, "halt": {"joints": CommandReply(accepted=True)}}
        self.teleop = KIND.load()(self.ctx)
        self.teleop.open()
        self.leader, self.follower = leader(), state(pan=0.1, lift=0.2)
        self.hear()

    def hear(self):
        self.ctx.now += 0.02
        if self.leader is not None:
            self.ctx.arrive("leader", self.leader, source="leader_joints")
        self.ctx.arrive("follower", self.follower, source="joints")

    def step(self, seconds=0.02):
        for _ in range(max(1, round(seconds / 0.02))):
            self.hear()
            self.teleop.step()

    def begin(self):
        call = FakeCall("begin", TeleopCommand(), arrived=self.ctx.now)
        self.teleop.command(call)
        self.step()
        return call

    def asked(self, request):
        return [asked.message for asked in self.ctx.asked if asked.request == request]

    @property
    def state(self):
        return self.ctx.said("state")[-1]


@pytest.fixture
def bench():
    return Bench()


def test_it_approaches_slowly_and_then_follows_fifty_times_a_second(bench):
    bench.follower = state(pan=-0.8, lift=0.2)
    call = bench.begin()
    first, *_ = bench.asked("move")
    assert (first.positions, first.speed_rps) == ({"pan": 0.1, "lift": 0.2}, SETTINGS.approach_rps)
    assert first.asked_s == call.arrived
    assert call.answer.accepted
    bench.step(1.0)
    assert bench.state.phase == "approaching"
    assert all(one.speed_rps == SETTINGS.approach_rps and one.lease == "l" for one in bench.asked("move")[1:])
    bench.follower = state(pan=0.05, lift=0.2)
    before = bench.state.sent
    bench.step(1.0)
    assert bench.state.phase == "following"
    assert bench.asked("move")[-1].speed_rps is None
    assert bench.teleop._following.sent - before >= 49


@pytest.mark.parametrize("lost", [None, leader(pan=None), leader(pan=nan), leader(age_s=0.5)])
def test_a_leader_that_is_lost_ends_it_and_the_follower_is_let_go_slowly(bench, lost):
    bench.begin()
    bench.step(0.2)
    bench.leader = lost
    bench.step(0.3)
    assert (bench.state.phase, bench.state.code) == ("idle", "stale_sensor")
    (halt,) = bench.asked("halt")
    assert halt.lost
    assert bench.ctx.told("teleop_ended")
    sent = len(bench.asked("move"))
    bench.leader = leader()
    bench.step(0.5)
    assert len(bench.asked("move")) == sent, "it does not begin again by itself"


def test_a_leader_that_is_not_known_does_not_begin(bench):
    bench.leader = leader(pan=None)
    bench.hear()
    call = bench.begin()
    assert "leader_pan is not measured" in call.refused
    assert not bench.ctx.asked


def test_a_stop_has_the_follower_hold(bench):
    bench.begin()
    call = FakeCall("stop", StopCommand(reason="enough"))
    bench.teleop.command(call)
    (halt,) = bench.asked("halt")
    assert not halt.lost
    assert call.answer.accepted
    assert bench.state.code == "stopped"


def test_a_lease_that_dies_ends_it(bench):
    bench.begin()
    bench.ctx.replies["move"] = REFUSED
    bench.step(0.1)
    assert (bench.state.phase, bench.state.code) == ("idle", "estop")


def test_joints_that_refuse_are_told_to_who_asked(bench):
    bench.ctx.replies["move"] = REFUSED
    call = bench.begin()
    bench.step(0.1)
    assert "the emergency stop is engaged" in call.refused


def test_it_follows_once_at_a_time(bench):
    bench.begin()
    assert "already" in bench.begin().refused
