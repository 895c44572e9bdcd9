"""Joints that begin to move beside others, each as fast as it may, and how strong they are."""

import pytest

from lbr.operations.joints.view import joints_state
from tests.operations.joints.joints_bench import BODY, DT, NAMES, Bench, frame

SLOW = {"left_knee": -1.0}


@pytest.fixture
def bench():
    return Bench().standing()


def later(bench):
    """Let a moment pass: of two commands in the same one, the second counts as come twice."""
    bench.now += 1e-5
    return bench


def joins(bench, positions, lease=""):
    return later(bench).command(positions, join=True, lease=lease)


def target(bench, name):
    return joints_state(bench.state, bench.now).joints[name].target_rad


def test_what_joins_leaves_the_others_as_they_were(bench):
    alone = Bench().standing()
    for one in (bench, alone):
        one.lease = one.command(SLOW, duration_s=2.0).lease
    told = []
    for step in range(100):
        if step % 7 == 0:
            later(alone)
            assert joins(bench, {"head_yaw": step / 200}, bench.lease).accepted
        bench.run(DT, bench.lease)
        alone.run(DT, alone.lease)
        told.append((bench.goals["left_knee"], alone.goals["left_knee"]))
    assert [ours for ours, _ in told] == pytest.approx([theirs for _, theirs in told], abs=1e-9)


def test_all_who_join_have_one_goal_which_is_reached_when_the_last_of_them_is(bench):
    first = bench.command({"left_knee": -1.0}, join=True)
    bench.run(0.2, first.lease)
    second = bench.command({"head_yaw": 0.8}, join=True, lease=first.lease)
    assert second.goal == first.goal
    assert (target(bench, "left_knee"), target(bench, "head_yaw")) == (-1.0, 0.8)
    bench.run(0.65, first.lease)
    assert target(bench, "left_knee") is None
    assert target(bench, "head_yaw") == 0.8
    assert bench.results == []
    bench.run(0.6, first.lease)
    (result,) = bench.results
    assert (result.goal, result.result) == (first.goal, "reached")
    assert bench.goals["left_knee"] == -1.0
    assert bench.goals["head_yaw"] == 0.8


def test_that_what_joined_has_arrived_is_a_result_but_no_news_unless_it_is_elsewhere(bench):
    reply = bench.command({"left_knee": -0.1}, join=True)
    bench.run(0.6, reply.lease)
    assert bench.results[-1].result == "reached"
    assert "reached" not in {event.kind for event in bench.events}
    bench.servos.stuck = {14}
    reply = bench.command({"left_knee": -0.5}, join=True)
    bench.run(1.5, reply.lease)
    assert any("left_knee is 0.40 rad away from its goal" in event.text for event in bench.events)


def test_a_lease_that_stays_moves_nothing_once_all_have_arrived(bench):
    reply = bench.command({"left_knee": -0.1}, join=True, stay=True)
    assert joints_state(bench.state, bench.now).moving
    bench.run(0.6, reply.lease)
    state = joints_state(bench.state, bench.now)
    assert (state.moving, state.holder, bench.results) == (False, "console", [])


def test_each_is_as_fast_as_its_own_row_allows_whoever_else_is_slow(bench):
    reply = bench.command({"left_knee": -1.0, "head_yaw": 0.8}, join=True, interpolation="linear")
    bench.run(0.25, reply.lease)
    assert bench.goals["left_knee"] == pytest.approx(-0.5, abs=0.03)
    assert bench.goals["head_yaw"] == pytest.approx(0.25, abs=0.02)
    assert "goes no faster" in bench.command({"head_yaw": 0.0}, join=True, duration_s=0.01, lease=reply.lease).reason


def test_what_joins_anew_goes_on_as_fast_as_it_goes_so_that_a_stream_of_it_arrives(bench):
    reply = bench.command({"head_yaw": -1.0}, join=True)
    for step in range(250):
        bench.command({"head_yaw": -1.0 + step % 2 / 1e6}, join=True, lease=reply.lease)
        bench.run(DT)
        if bench.results:
            break
    assert bench.goals["head_yaw"] == pytest.approx(-1.0, abs=1e-3)
    assert bench.now - 100.0 < 3.0


def test_what_joins_anew_in_the_other_direction_turns_back_smoothly(bench):
    reply = bench.command({"left_knee": -1.0}, join=True)
    bench.run(0.2, reply.lease)
    before = bench.goals["left_knee"]
    joins(bench, {"left_knee": 0.0}, reply.lease)
    bench.run(DT, reply.lease)
    assert abs(bench.goals["left_knee"] - before) < 0.3 * 2.0 * DT


def test_what_joins_begins_as_fast_as_it_may_wherever_it_is(bench):
    lease = bench.command({"left_knee": -1.0}, join=True, stay=True).lease
    bench.run(1.0, lease)
    joins(bench, {"left_knee": -0.2}, lease)
    bench.run(DT, lease)
    assert bench.goals["left_knee"] + 1.0 > 0.7 * 2.0 * DT


def test_a_joint_on_its_way_that_joins_anew_between_two_rounds_does_not_jump(bench):
    lease = bench.command({"left_shoulder_pitch": 2.0}, join=True, interpolation="linear").lease
    bench.run(0.2, lease)
    before = bench.goals["left_shoulder_pitch"]
    bench.now = round(bench.now + DT / 2, 6)
    bench.command({"left_shoulder_pitch": 2.1}, join=True, interpolation="linear", lease=lease)
    assert abs(bench.goals["left_shoulder_pitch"] - before) <= 2.0 * DT / 2 + 1e-9


def test_it_begins_with_the_setpoint_that_follows_at_once_and_never_jumps(bench):
    before = bench.goals["left_shoulder_pitch"]
    bench.now = round(bench.now + DT / 2, 6)
    bench.command({"left_shoulder_pitch": 0.5}, join=True, interpolation="linear")
    moved = abs(bench.goals["left_shoulder_pitch"] - before)
    assert 0.0 < moved <= 2.0 * DT / 2 + 1e-9


def test_what_joins_right_after_a_stop_begins_no_earlier_than_that(bench):
    bench.now = round(bench.now + DT - 1e-4, 6)
    bench.stop()
    before = bench.goals["left_shoulder_pitch"]
    later(bench).command({"left_shoulder_pitch": 0.5}, join=True, interpolation="linear")
    assert abs(bench.goals["left_shoulder_pitch"] - before) <= 2.0 * 1e-5 + 1e-9


def test_a_joint_that_joins_leaves_the_key_frames_and_what_is_appended_takes_it_again(bench):
    first = bench.command(frames=(frame(1.0, left_knee=-0.5, head_yaw=0.5),))
    bench.run(0.5, first.lease)
    joins(bench, {"head_yaw": 0.0}, first.lease)
    later(bench).command(frames=(frame(0.5, left_knee=-1.0),), append=True, lease=first.lease)
    bench.run(1.2, first.lease)
    assert bench.goals["left_knee"] == -1.0
    assert bench.goals["head_yaw"] == 0.0
    assert [each.result for each in bench.results] == ["reached"]
    assert joints_state(bench.state, bench.now).passed == 0


@pytest.mark.parametrize("more", [{"frames": (), "append": True}, {"positions": {}}])
def test_only_positions_can_join(bench, more):
    reply = bench.command(**{"positions": SLOW, **more}, join=True)
    assert not reply.accepted


def test_a_hundred_joins_a_second_leave_little_behind(bench):
    reply = bench.command(dict.fromkeys(NAMES, 0.0), join=True)
    for step in range(300):
        name = NAMES[step % len(NAMES)]
        bench.run(DT)
        again = bench.command({name: 0.001 * (step % 50)}, join=True, lease=reply.lease if reply.accepted else "")
        reply = again if again.accepted else bench.command({name: 0.0}, join=True)
    move = bench.state.move
    assert move is None or len(move.beside) <= len(NAMES)
    assert not [event for event in bench.events if event.kind == "superseded"]


def test_a_joint_that_is_near_its_goal_but_on_its_way_goes_on_when_another_joins(bench):
    lease = bench.command({"left_knee": -0.04}, join=True, duration_s=1.0).lease
    joins(bench, {"head_yaw": 0.1}, lease)
    assert set(bench.state.move.beside) == {"left_knee", "head_yaw"}


@pytest.mark.parametrize("rests", [True, False])
def test_a_joint_that_has_come_to_its_goal_is_left_out_once_another_joins_and_one_that_has_not_is_not(bench, rests):
    lease = joins(bench, {"left_knee": -0.3}).lease
    lease = later(bench).command({"left_knee": -0.3}, join=True, stay=True, lease=lease).lease
    bench.run(0.6, lease)
    if not rests:
        bench.push("left_knee", 0.05)
        bench.hear()
    joins(bench, {"head_yaw": 0.1}, lease)
    assert set(bench.state.move.beside) == ({"head_yaw"} if rests else {"left_knee", "head_yaw"})


# strength


def strengths(bench):
    return {BODY_NAMES[goal.id]: goal.torque for goal in bench.setpoint.goals if goal.torque > 0.0}


BODY_NAMES = {joint.device_id: name for name, joint in BODY.joints.items()}


def test_a_command_with_torque_gives_its_joints_torque_where_they_are_and_moves_them(bench):
    bench.torque(on=False, confirmed=True)
    bench.push("left_knee", -0.3)
    bench.run(0.3)
    reply = bench.command(SLOW, torque=0.4, join=True)
    assert reply.accepted
    assert strengths(bench) == {"left_knee": 0.4}
    assert bench.goals["left_knee"] == pytest.approx(-0.3, abs=2.0 * DT)
    assert "console switched the torque of left_knee on" in {event.text for event in bench.events}
    bench.run(0.8, reply.lease)
    assert bench.goals["left_knee"] == -1.0


def test_each_joint_may_have_a_strength_of_its_own_and_all_of_them_begin_or_none(bench):
    bench.torque(on=False, confirmed=True)
    bench.run(0.3)
    both = {"left_knee": -1.0, "head_yaw": 0.5}
    assert bench.command(both, torques={"left_knee": 0.2}, join=True).reason.startswith("head_yaw has no torque")
    assert bench.command(both, torques={"left_kne": 0.2}).reason.endswith("does not move: left_kne")
    assert strengths(bench) == {}
    bench.command(both, torques={"left_knee": 0.2, "head_yaw": 0.8}, join=True)
    assert strengths(bench) == {"left_knee": 0.2, "head_yaw": 0.8}
    bench.stop()
    bench.run(DT)
    bench.command({"left_knee": -1.0}, torque=1.0, torques={"left_knee": 0.6}, mirror=True)
    assert strengths(bench) == {"left_knee": 0.2, "right_knee": 0.6, "head_yaw": 0.8}


def test_a_strength_that_is_said_again_does_not_hide_that_a_servo_lost_its_torque(bench):
    bench.run(1.0)
    bench.command(SLOW, torque=0.5)
    bench.servos.powerless = {14: "was it without power?"}
    bench.hear()
    assert "left_knee" not in bench.state.on


def test_strength_stays_until_it_is_said_again_or_switched_on_anew(bench):
    reply = bench.command(SLOW, torque=0.2)
    bench.run(DT, reply.lease)
    later(bench).command({"left_knee": -0.5}, lease=reply.lease)
    assert strengths(bench)["left_knee"] == 0.2
    assert strengths(bench)["head_yaw"] == 1.0
    later(bench).command({"left_knee": -0.2}, torque=0.8, lease=reply.lease)
    bench.run(DT, reply.lease)
    assert strengths(bench)["left_knee"] == 0.8
    bench.torque("left_knee", on=True)
    assert strengths(bench)["left_knee"] == 1.0


def test_a_process_that_begins_anew_leaves_joints_as_weak_as_it_finds_them(bench):
    bench.command(SLOW, torque=0.4)
    bench.run(0.1)
    bench.restart()
    bench.run(0.1)
    assert strengths(bench)["left_knee"] == 0.4
    assert bench.setpoint.lost


def test_a_joint_waits_no_longer_than_until_the_driver_has_heard_that_it_let_go(bench):
    bench.run(1.0)
    bench.servos.latched = {14: ("overload",)}
    bench.run(0.02)
    bench.servos.latched = {}
    bench.run(0.05)
    reply = bench.command(SLOW, torque=1.0)
    bench.run(0.02, reply.lease)
    assert "left_knee" not in strengths(bench)
    bench.run(0.08, reply.lease)
    assert bench.goals["left_knee"] < 0.0


def test_a_joint_that_cannot_be_held_is_refused_by_name_and_none_of_them_moves(bench):
    bench.torque(on=False, confirmed=True)
    bench.push("left_knee", -2.3)
    bench.run(0.3)
    reply = bench.command({"left_knee": -1.0, "head_yaw": 0.1}, torque=1.0, join=True)
    assert reply.reason.startswith("left_knee is at -2.30 rad, outside its limits")
    assert strengths(bench) == {}


def test_servos_that_cannot_say_whether_they_have_torque_are_not_waited_for():
    bench = Bench()
    bench.servos.tells_torque = False
    bench.run(0.02)
    reply = bench.command(SLOW, torque=0.4, join=True)
    assert reply.accepted
    assert strengths(bench) == {"left_knee": 0.4}
    bench.run(0.8, reply.lease)
    assert (bench.goals, bench.results[-1].result) == ({"left_knee": -1.0}, "reached")


@pytest.mark.parametrize("torque", [0.0, -1.0, 2.0, float("nan")])
def test_a_strength_that_is_none_is_refused(bench, torque):
    assert "torque" in bench.command(SLOW, torque=torque).reason


@pytest.mark.parametrize("join", [True, False])
def test_joints_that_just_let_go_begin_when_the_driver_has_heard_that(bench, join):
    bench.run(1.0)
    bench.servos.latched = {14: ("overload",)}
    bench.run(0.02)
    bench.servos.latched = {}
    bench.hear()
    reply = bench.command(SLOW | {"head_yaw": 0.5}, torque=1.0, join=join)
    assert reply.accepted
    bench.run(0.05, reply.lease)
    assert "left_knee" not in strengths(bench)
    assert (bench.goals["head_yaw"] > 0.0) is join, "what moves together begins together"
    bench.run(0.06, reply.lease)
    assert bench.goals["left_knee"] == pytest.approx(bench.measured("left_knee"), abs=0.05)
    assert bench.goals["left_knee"] > -0.1
