"""Joints whose position nobody can tell: moved all the same where the row says so, by the clock and what was told."""

import pytest

from lbr.messages.joints import StoredMotion
from lbr.operations.joints.planning import UNKNOWN_S
from lbr.operations.joints.view import joints_state
from tests.operations.joints.joints_bench import NAMES, Bench

KNEE = 14
POSE = {"left_knee": -0.3}


@pytest.fixture
def bench():
    made = Bench(open_loop=True)
    made.servos.doubted = set(made.servos.at)
    made.servos.stores = True
    return made.run(0.05)


@pytest.mark.parametrize("how", [{"join": True}, {}, {"duration_s": 0.5}, {"speed_rps": 2.0}])
def test_a_joint_that_nobody_knows_starts_at_its_goal_and_has_the_time_that_a_weak_servo_needs(bench, how):
    reply = bench.command({"left_knee": -1.0}, torque=0.6, **how)
    assert reply.accepted
    bench.run(0.02, reply.lease)
    assert bench.goals == {"left_knee": -1.0}
    bench.run(UNKNOWN_S - 0.12, reply.lease)
    assert bench.results == []
    bench.run(0.2, reply.lease)
    assert bench.results[-1].result == "reached"
    assert "away from its goal" not in bench.results[-1].reason
    assert joints_state(bench.state, bench.now).joints["left_knee"].position_rad is None


def test_from_then_on_it_counts_as_being_where_it_was_told_to_be(bench):
    reply = bench.command({"left_knee": -1.0}, torque=1.0)
    bench.run(2.1, reply.lease)
    again = bench.command({"left_knee": 0.0}, join=True, interpolation="linear")
    bench.run(0.25, again.lease)
    assert bench.goals["left_knee"] == pytest.approx(-0.5, abs=0.03)
    bench.stop()
    assert bench.goals["left_knee"] == pytest.approx(-0.5, abs=0.03)
    bench.torque("left_knee", on=False)
    bench.now += 0.001
    third = bench.command({"left_knee": -1.5}, torque=1.0)
    bench.run(0.02, third.lease)
    assert bench.goals["left_knee"] == -1.5, "without torque it may be anywhere"


def test_after_a_stored_motion_it_counts_as_being_at_its_pose(bench):
    reply = bench.command(stored=StoredMotion(slot=7, duration_s=1.0, pose=POSE))
    bench.run(0.1, reply.lease)
    bench.servos.plays("over")
    bench.run(0.02, reply.lease)
    assert bench.goals == dict.fromkeys(NAMES) | POSE
    again = bench.command({"left_knee": 0.0, "head_yaw": 0.5}, join=True)
    bench.run(0.1, again.lease)
    assert -0.3 < bench.goals["left_knee"] < 0.0
    assert bench.goals["head_yaw"] == 0.5


def test_a_joint_that_is_measured_is_moved_from_there_also_when_that_ceases_on_the_way(bench):
    bench.servos.doubted = set()
    bench.push("left_knee", -0.6)
    bench.run(0.02)
    reply = bench.command({"left_knee": -1.0}, torque=1.0, duration_s=1.0)
    bench.run(0.5, reply.lease)
    assert bench.goals["left_knee"] == pytest.approx(-0.8, abs=0.02)
    bench.servos.doubted = {KNEE}
    bench.run(0.6, reply.lease)
    assert bench.results[-1].result == "reached"
    assert bench.goals["left_knee"] == -1.0


def test_a_joint_that_is_measured_away_from_its_goal_is_named(bench):
    bench.servos.doubted, bench.servos.stuck = set(), {KNEE}
    bench.run(0.02)
    reply = bench.command({"left_knee": -0.5}, torque=1.0, duration_s=0.5)
    bench.run(1.1, reply.lease)
    assert bench.results[-1].reason.endswith("left_knee is 0.50 rad away from its goal")


def test_where_the_row_does_not_say_so_it_is_refused_by_name(wording):
    bench = Bench().standing()
    bench.servos.doubted = {KNEE}
    bench.run(0.02)
    wording(bench.command({"left_knee": -1.0}))
    state = joints_state(bench.state, bench.now).joints["left_knee"]
    assert (state.position_rad, state.trusted) == (None, False)


def test_a_servo_that_has_latched_or_is_not_known_is_refused_all_the_same(bench):
    bench.servos.latched = {KNEE: ("overload",)}
    bench.run(0.02)
    assert "left_knee has latched overload" in bench.command({"left_knee": -1.0}, torque=1.0).reason
