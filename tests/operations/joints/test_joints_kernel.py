"""The joints kernel: who may move what, how motions begin, go on and end, and what the servos are told."""

import pytest

from lbr.leases.lease import Stop
from lbr.messages.joints import MAX_FRAMES, TorqueCommand
from lbr.messages.servos import ServosState
from lbr.operations.joints.state import ServosSeen, Tick, Torque
from lbr.operations.joints.view import joints_state
from tests.operations.joints.joints_bench import BODY, DT, NAMES, START, Bench, frame

SLOW = {"left_knee": -1.0}


@pytest.fixture
def bench():
    return Bench().standing()


def last(bench):
    return bench.results[-1].result, bench.results[-1].reason


# starting


def test_start_up_moves_nothing_and_switches_nothing_on():
    bench = Bench()
    bench.run(0.1)
    assert {goal.torque for goal in bench.setpoint.goals} == {0.0}
    assert (bench.setpoint.lost, bench.setpoint.halt) == (False, 1)


def test_nothing_is_said_to_servos_that_were_never_heard(wording):
    bench = Bench().run(0.5, hear=False)
    assert (bench.setpoint, joints_state(bench.state, bench.now).sequence) == (None, 0)
    wording(bench.command(SLOW))


def test_servos_that_hold_when_the_process_begins_anew_go_on_holding_where_they_are_until_somebody_cares(bench):
    bench.command({"left_knee": -1.0}, duration_s=1.0)
    bench.run(0.1)
    bench.servos.phase = "holding"
    where = dict(bench.servos.at)
    bench.restart()
    bench.run(0.2)
    assert bench.setpoint.lost
    assert bench.goals == pytest.approx({name: bench.measured(name) for name in NAMES})
    assert bench.servos.at == where
    assert bench.command({"left_knee": 0.0}).accepted
    assert not bench.setpoint.lost


# commands


def test_positions_are_reached_smoothly_and_the_result_says_so(bench):
    reply = bench.command({"left_knee": -1.0, "head_yaw": 0.5}, duration_s=2.0)
    assert (reply.accepted, reply.reason, reply.ttl_s) == (True, "", 0.3)
    bench.run(1.0, reply.lease)
    assert bench.goals["left_knee"] == pytest.approx(-0.5, abs=0.02)
    assert bench.goals["right_knee"] == 0.0
    assert bench.setpoint.lease == reply.lease
    bench.run(1.1, reply.lease)
    assert bench.measured("left_knee") == pytest.approx(-1.0)
    (result,) = bench.results
    assert (result.goal, result.result) == (reply.goal, "reached")
    assert result.elapsed_s == pytest.approx(2.0, abs=2 * DT)
    assert "reached" in {event.kind for event in bench.events}
    assert bench.state.leases.live is None
    assert not bench.setpoint.lost


@pytest.mark.parametrize("asked", [{"duration_s": 0.1}, {"speed_rps": 8.0}])
@pytest.mark.parametrize("join", [False, True])
def test_speed_decides_how_long_it_takes_and_the_rows_speed_is_never_passed(bench, join, asked):
    slow = bench.command({"left_knee": -1.0}, speed_rps=0.5, join=join)
    assert slow.reason == ""
    bench.run(1.9, slow.lease)
    assert bench.results == []
    bench.run(0.2, slow.lease)
    assert last(bench)[0] == "reached"
    fast = bench.command({"left_knee": -0.2}, join=join, **asked)
    assert fast.reason == "takes 0.60 s instead of 0.10: left_knee goes no faster than 2 rad/s"


@pytest.mark.parametrize(
    ("command", "code", "about"),
    [
        ({}, "bad_value", ("nothing to move",)),
        ({"frames": (frame(),)}, "bad_value", ("nothing to move",)),
        ({"positions": SLOW, "frames": (frame(left_knee=0.0),)}, "bad_value", ("positions", "frames", "both")),
        ({"positions": {"left_kne": 0.0}}, "unknown_name", ("'left_kne'", "left_knee or right_knee")),
        ({"positions": {"head_yaw": 0.9}}, "limit", ("head_yaw 0.9 rad (52 degrees)", "(-1 to 0.8 rad")),
        ({"positions": {"head_yaw": float("nan")}}, "bad_value", ("head_yaw", "nan", "angle")),
        ({"positions": SLOW, "duration_s": float("nan")}, "bad_value", ("duration_s nan", "0 to 60")),
        ({"positions": SLOW, "speed_rps": float("inf")}, "bad_value", ("speed_rps inf",)),
        ({"positions": SLOW, "ttl_s": float("nan")}, "bad_value", ("ttl_s nan", "0 to 1")),
        ({"frames": (frame(-1.0, left_knee=0.0),)}, "bad_value", ("duration_s -1", "0 to 60")),
        ({"positions": SLOW, "received": START - 1.0}, "late", ("1.1 s",)),
        ({"positions": SLOW, "lease": "old"}, "dead_lease", ("not known",)),
        ({"positions": {"right_grip": 0.5}, "mirror": True}, "not_possible", ("right_grip", "mirror")),
        ({"positions": {"head_yaw": -0.9}, "mirror": True}, "limit", ("head_yaw 0.9 rad (52 degrees)",)),
        ({"frames": (frame(left_knee=0.0),), "append": True}, "bad_value", ("append", "lease")),
    ],
)
def test_a_command_that_makes_no_sense_is_refused_with_a_sentence(bench, command, code, about):
    reply = bench.command(**command)
    assert (reply.accepted, reply.code) == (False, code)
    assert all(name in reply.reason for name in about), reply.reason
    assert bench.state.move is None


def test_what_is_wrong_in_several_frames_is_said_once(bench):
    assert bench.command(frames=(frame(left_kne=0.0),) * 2).reason.count("'left_kne'") == 1


def test_joints_without_torque_are_refused_by_name(wording):
    bench = Bench().run(0.05)
    bench.torque("right_knee", on=True)
    wording(bench.command({"left_knee": -0.1}), bench.command({"left_knee": -0.1, "head_yaw": 0.0}))
    assert bench.command({"right_knee": -0.1}).accepted


def test_a_second_sender_is_told_who_holds_the_joints_and_may_take_over(bench):
    first = bench.command(SLOW, duration_s=2.0)
    assert bench.command({"head_yaw": 0.1}, source="pad").reason == "held by console; stop it first"
    bench.run(0.5, first.lease)
    before = bench.goals["left_knee"]
    second = bench.command({"head_yaw": 0.1}, source="pad", take_over=True)
    assert second.accepted
    assert last(bench) == ("superseded", "taken over by pad")
    bench.run(0.1, second.lease)
    assert bench.goals["left_knee"] == before
    assert bench.command(lease=first.lease).reason == "lease is dead: taken over by pad"


def test_another_command_under_the_same_lease_goes_on_from_where_the_joint_was_told_to_be(bench):
    first = bench.command(SLOW, duration_s=2.0)
    bench.run(1.0, first.lease)
    told = bench.goals["left_knee"]
    second = bench.command({"left_knee": 0.0}, duration_s=2.0, lease=first.lease)
    assert (second.lease, last(bench)[0]) == (first.lease, "superseded")
    assert second.goal != first.goal
    bench.run(DT, second.lease)
    assert bench.goals["left_knee"] == pytest.approx(told, abs=0.02)


def test_another_command_under_the_same_lease_goes_on_as_fast_as_the_joint_goes_already(bench):
    lease = bench.command(SLOW, duration_s=2.0).lease
    bench.run(1.0, lease)
    told = bench.goals["left_knee"]
    bench.command({"left_knee": -2.0}, duration_s=2.0, lease=lease)
    bench.run(DT, lease)
    assert told - bench.goals["left_knee"] == pytest.approx(1.5 / 2.0 * DT, rel=0.05)


def test_the_same_command_again_is_a_renewal_for_any_time_and_so_is_the_lease_alone(bench):
    first = bench.command(SLOW, duration_s=1.0)
    for again in ({}, SLOW, {}):
        bench.run(0.2)
        more = {"duration_s": 1.0, "ttl_s": 0.5, "asked_s": bench.now} if again else {}
        assert bench.command(again, lease=first.lease, **more).goal == first.goal
    bench.run(0.42, first.lease)
    assert last(bench)[0] == "reached"


def test_a_remote_command_moves_nothing_before_its_lease_was_quoted(bench):
    offer = bench.command(SLOW, source="far", remote=True, sender_s=5.0)
    assert offer.accepted
    bench.run(0.1)
    assert bench.goals["left_knee"] == 0.0
    confirmed = bench.command(source="far", remote=True, sender_s=5.1, lease=offer.lease)
    assert (confirmed.accepted, confirmed.goal) == (True, offer.goal)
    bench.run(0.1)
    assert bench.goals["left_knee"] < 0.0


# key frames


def test_key_frames_are_passed_in_turn_and_counted(bench):
    frames = (frame(0.5, left_knee=-0.4, right_knee=-0.4), frame(0.5, left_knee=-0.8))
    reply = bench.command(frames=frames)
    bench.run(0.5, reply.lease)
    assert bench.goals["left_knee"] == pytest.approx(-0.4, abs=0.02)
    bench.run(0.55, reply.lease)
    assert (bench.goals["left_knee"], bench.goals["right_knee"]) == (-0.8, -0.4)
    assert last(bench)[0] == "reached"


def test_frames_that_are_appended_follow_under_the_same_goal_without_a_stop(bench):
    first = bench.command(frames=(frame(0.5, left_knee=-0.4),))
    bench.run(0.25, first.lease)
    more = bench.command(frames=(frame(0.5, left_knee=-0.8),), append=True, lease=first.lease)
    bench.run(DT)
    again = bench.command(frames=(frame(0.5, left_knee=-1.2),), append=True, lease=first.lease)
    assert more.goal == again.goal == first.goal
    bench.run(0.25, first.lease)
    before = bench.goals["left_knee"]
    assert joints_state(bench.state, bench.now).passed == 1
    bench.run(0.05, first.lease)
    assert before - bench.goals["left_knee"] > 0.03
    bench.run(0.6, first.lease)
    assert joints_state(bench.state, bench.now).passed == 2
    bench.run(1.0, first.lease)
    assert bench.goals["left_knee"] == -1.2
    assert [each.result for each in bench.results] == ["reached"]


def test_a_mirrored_motion_is_done_by_the_other_side(bench):
    reply = bench.command({"left_knee": -0.4, "head_yaw": 0.2}, duration_s=0.5, mirror=True)
    bench.run(0.6, reply.lease)
    assert bench.goals["right_knee"] == pytest.approx(-0.4)
    assert bench.goals["head_yaw"] == pytest.approx(-0.2)
    assert bench.goals["left_knee"] == 0.0


# ends


def test_a_lease_that_lapses_ends_the_motion_and_says_that_the_mover_is_lost(bench):
    reply = bench.command(SLOW, duration_s=2.0)
    bench.run(0.5)
    assert last(bench)[0] == "lapsed"
    assert bench.setpoint.lost
    where = bench.goals
    bench.run(1.0)
    assert bench.goals == where
    assert not bench.command(lease=reply.lease).accepted
    bench.servos.released_at()
    bench.run(0.1)
    assert bench.goals == {}
    assert "torque on first" in bench.command(SLOW).reason


def test_a_holder_whose_process_is_gone_is_lost(bench):
    bench.command(SLOW, duration_s=2.0)
    bench.lose_holder("pad")
    assert bench.results == []
    bench.lose_holder("console")
    assert last(bench) == ("lapsed", "the process of console is gone")
    assert bench.setpoint.lost


def test_no_more_is_appended_than_can_be_planned_without_being_late(bench, wording):
    many = tuple(frame(0.01, left_knee=-0.01 * (at % 2)) for at in range(600))
    lease = bench.command(frames=many).lease
    bench.run(0.05, lease)
    refused = bench.command(frames=many, append=True, lease=lease)
    wording(refused)
    assert bench.command(frames=many[:100], append=True, lease=lease).accepted


def test_anybody_stops_every_joint_where_it_was_measured(bench):
    bench.command(SLOW, duration_s=2.0)
    bench.run(0.25)
    bench.push("left_knee", -0.2)
    bench.hear()
    halts = bench.setpoint.halt
    assert bench.stop().accepted
    assert bench.goals["left_knee"] == pytest.approx(-0.2)
    assert bench.setpoint.halt == halts + 1
    assert not bench.setpoint.lost
    state = joints_state(bench.state, bench.now)
    assert (state.stopped_s, state.stopped_by, state.halted_s, state.halted_by) == (bench.now, "phone") * 2
    assert last(bench) == ("stopped", "stopped by phone: test")


@pytest.mark.parametrize(("source", "how"), [("console", "lapsed"), ("phone", "stopped")])
def test_who_holds_the_joints_for_others_may_say_that_these_are_lost(bench, source, how):
    bench.command(SLOW)
    bench.give(Stop(source=source, received=bench.now, reason="test", lost=True))
    assert last(bench)[0] == how
    assert bench.setpoint.lost == (how == "lapsed")
    assert bench.stop().accepted


def test_a_stop_leaves_it_to_the_driver_where_a_joint_is_that_was_not_measured_just_now(bench):
    reply = bench.command(SLOW, duration_s=2.0)
    bench.run(0.25, reply.lease)
    bench.run(0.1, reply.lease, hear=False)
    bench.stop()
    assert bench.goals["left_knee"] is None
    assert bench.goals["right_knee"] == 0.0


def test_a_joint_whose_measure_is_old_is_not_taken_back_there_after_a_stop(bench):
    reply = bench.command(SLOW, duration_s=2.0)
    bench.run(0.25, reply.lease)
    bench.servos.ages_s = {14: 0.2}
    bench.hear()
    bench.stop()
    bench.run(0.1)
    assert bench.goals["left_knee"] is None
    bench.push("left_knee", -0.4)
    bench.servos.ages_s = {}
    bench.run(0.02)
    assert bench.goals["left_knee"] == pytest.approx(-0.4)


def test_a_joint_that_was_pushed_far_beyond_its_limits_stays_and_may_be_brought_back(bench):
    bench.servos.stuck = {14}
    bench.push("left_knee", 0.6)
    bench.hear()
    bench.stop()
    bench.run(0.1)
    assert bench.goals["left_knee"] is None
    reply = bench.command({"left_knee": 0.0}, duration_s=1.0)
    bench.run(0.1, reply.lease)
    assert 0.5 < bench.goals["left_knee"] < 0.6


def test_a_stop_of_what_stands_leaves_a_joint_that_sags_a_little_its_goal(bench):
    bench.push("left_knee", -0.03)
    bench.push("right_knee", -0.3)
    bench.hear()
    bench.stop()
    assert bench.goals["left_knee"] == 0.0
    assert bench.goals["right_knee"] == pytest.approx(-0.3)


def test_the_emergency_stop_ends_everything_and_its_reset_moves_nothing(bench):
    reply = bench.command(SLOW, duration_s=2.0)
    bench.run(0.2, reply.lease)
    bench.estop()
    where = bench.goals
    assert last(bench) == ("fault", "emergency stop: test")
    assert bench.command({"head_yaw": 0.1}).reason == "emergency stop: test; 'reset' releases it"
    bench.run(0.3)
    bench.estop(engaged=False)
    bench.run(0.3)
    assert bench.goals == where


def test_servos_that_an_emergency_stop_let_go_stay_without_torque(bench):
    bench.estop()
    bench.servos.released_at()
    bench.servos.armed, bench.servos.estop, bench.servos.reason = False, True, "emergency stop"
    bench.run(0.1)
    bench.servos.armed, bench.servos.estop = True, False
    bench.estop(engaged=False)
    bench.run(0.1)
    assert bench.goals == {}


def test_a_driver_that_is_gone_ends_the_motion_and_back_again_is_taken_as_it_is(bench):
    bench.command(SLOW, duration_s=2.0)
    bench.run(0.25)
    bench.lose_servos()
    assert last(bench) == ("fault", "the servo driver (servos) is gone")
    bench.setpoint = None
    bench.run(0.1, hear=False)
    assert bench.setpoint is None
    bench.push("left_knee", -0.5)
    bench.run(0.02)
    assert bench.goals["left_knee"] == pytest.approx(-0.5)
    assert not bench.setpoint.lost


def test_a_joint_that_sags_under_its_load_is_taken_over_at_its_goal_and_not_where_it_sagged_to(bench):
    bench.standing()
    knee, yaw, other = BODY.joints["left_knee"], BODY.joints["head_yaw"], BODY.joints["right_knee"]
    bench.push("left_knee", -1.0)
    bench.push("head_yaw", 0.5)
    bench.push("right_knee", 0.12)
    bench.servos.held_at = {
        knee.device_id: BODY.servo_rad("left_knee", -1.0 + bench.settings.tolerance_rad / 2),
        yaw.device_id: BODY.servo_rad("head_yaw", 0.5 - 3 * bench.settings.tolerance_rad),
        other.device_id: BODY.servo_rad("right_knee", 0.13),
    }
    bench.restart()
    bench.run(0.1)
    assert bench.goals["left_knee"] == pytest.approx(-1.0 + bench.settings.tolerance_rad / 2)
    assert bench.goals["head_yaw"] == pytest.approx(0.5), "far from its goal it is held where it is"
    assert bench.goals["right_knee"] == 0.1, "at its limit, if its goal is beyond that"


def test_a_driver_that_has_just_begun_is_not_believed_before_it_knows_which_servos_have_torque(bench):
    bench.lose_servos()
    bench.setpoint = None
    bench.servos.unread, bench.servos.phase = True, "released"
    bench.run(0.3)
    assert bench.setpoint is None
    bench.servos.unread, bench.servos.phase = False, "holding"
    bench.servos.missing = {14}
    bench.run(0.05)
    assert set(bench.goals) == set(NAMES)
    assert bench.goals["left_knee"] is None


def test_a_driver_that_never_says_which_servos_have_torque_is_not_waited_for_for_ever():
    bench = Bench()
    bench.servos.unread = True
    bench.run(2.9)
    assert bench.setpoint is None
    bench.run(0.2)
    assert {goal.torque for goal in bench.setpoint.goals} == {0.0}


def test_a_servo_that_is_heard_later_than_the_others_is_not_let_go_by_a_process_that_begins(bench):
    bench.servos.missing = {14}
    bench.restart()
    bench.run(1.1)
    assert set(bench.goals) == set(NAMES) - {"left_knee"}
    bench.servos.missing, bench.servos.torque[14] = set(), 1.0
    bench.hear()
    bench.give(Tick())
    assert set(bench.goals) == set(NAMES)
    assert bench.setpoint.lost


def test_torque_is_not_switched_before_it_is_known_who_has_any(bench):
    bench.servos.unread = True
    bench.restart()
    bench.run(0.1)
    for on in (True, False):
        assert "the search for servos goes on" in bench.torque("left_knee", on=on).reason
    assert bench.command(SLOW, torque=0.5).code == "not_ready"


def test_a_driver_that_lost_its_line_lets_nothing_fall_when_it_is_back(bench, wording):
    sweep, bench.servos.state = (
        bench.servos.state,
        lambda now: ServosState(
            sweep=0, measured_s=now, armed=False, phase="released", servos=(), reason="the cable is out"
        ),
    )
    bench.run(0.1)
    wording(bench.command(SLOW))
    assert {joint.reason for joint in joints_state(bench.state, bench.now).joints.values()} == {
        "the servos are not armed"
    }
    bench.servos.state = sweep
    bench.run(0.1)
    assert set(bench.goals) == set(NAMES)
    assert bench.command(SLOW).accepted


def test_a_driver_that_holds_although_it_is_told_to_follow_ends_the_motion(bench, wording):
    reply = bench.command(SLOW, duration_s=2.0)
    bench.run(0.1, reply.lease)
    bench.servos.obey = lambda setpoint: None
    bench.servos.phase, bench.servos.reason, bench.servos.code = "holding", "the lease has died", "no_setpoint"
    bench.run(0.02, reply.lease)
    assert bench.results[-1].code == "no_setpoint"
    wording(*last(bench))


@pytest.mark.parametrize("followed_s", [0.0, 0.1])
def test_a_stream_of_commands_is_no_reason_to_wait_for_servos_for_ever(bench, followed_s, wording):
    reply = bench.command(SLOW, duration_s=2.0)
    bench.run(followed_s, reply.lease)
    bench.servos.obey = lambda setpoint: None
    bench.servos.phase, bench.servos.reason = "holding", "the lease has died"
    for turn in range(40):
        bench.run(0.01)
        bench.command(SLOW, duration_s=2.0 + turn / 100, lease=reply.lease)
    assert bench.results[-1].code == "not_followed"
    wording(*last(bench))


def test_a_servo_that_was_without_power_stays_without_torque_until_it_is_switched_on(bench):
    bench.run(1.0)
    bench.servos.powerless = {14: "was it without power?"}
    bench.run(0.02)
    assert "left_knee" not in bench.goals
    assert bench.events[-1].text == "left_knee is without torque: was it without power?"
    assert bench.events[-1].code == "no_torque"
    assert "torque on first" in bench.command(SLOW).reason
    bench.servos.powerless = {}
    assert bench.torque("left_knee", on=True).accepted
    bench.run(0.05)
    assert "left_knee" not in bench.goals, "the driver is to hear of it without torque first"
    bench.run(1.1)
    assert "left_knee" in bench.goals


def test_joints_that_the_driver_has_let_go_get_torque_again_once_it_has_heard_of_them_without(bench):
    bench.command(SLOW, duration_s=2.0)
    bench.run(0.5)
    bench.servos.released_at()
    bench.run(0.05)
    assert bench.torque(on=True).accepted
    bench.run(0.04)
    assert bench.goals == {}
    bench.run(0.03)
    assert set(bench.goals) == set(NAMES)


@pytest.mark.parametrize(("ahead_s", "code"), [(-0.25, "unreachable"), (0.25, "")])
def test_a_sweep_counts_from_its_arrival_and_never_from_later_than_now(bench, ahead_s, code):
    bench.give(ServosSeen(servos=bench.servos.state(bench.now), arrived=bench.now + ahead_s))
    bench.run(0.25, hear=False)
    assert bench.command(SLOW).code == code
    bench.run(0.25, hear=False)
    assert bench.command(SLOW).code == "unreachable"


def test_a_silent_driver_ends_the_motion(bench, wording):
    reply = bench.command(SLOW, duration_s=2.0)
    bench.run(0.28, reply.lease, hear=False)
    assert bench.results == []
    bench.run(0.1, reply.lease, hear=False)
    wording(*last(bench))


def test_a_joint_of_the_motion_that_latches_a_fault_ends_it_and_needs_its_torque_switched_on_again(bench, wording):
    reply = bench.command(SLOW, duration_s=2.0)
    bench.run(0.1, reply.lease)
    bench.servos.latched = {14: ("overload",)}
    bench.run(0.02, reply.lease)
    wording(*last(bench))
    assert "left_knee" not in bench.goals
    assert "right_knee" in bench.goals
    assert "left_knee is without torque: it has latched overload" in {event.text for event in bench.events}
    bench.servos.latched = {}
    bench.run(0.1)
    assert "left_knee" not in bench.goals
    assert bench.torque("left_knee", on=True).accepted
    bench.run(DT)
    assert "left_knee" in bench.goals


def test_a_fault_of_a_joint_that_does_not_move_is_nobodys_business(bench):
    reply = bench.command(SLOW, duration_s=1.0)
    bench.servos.latched = {13: ("overheating",)}
    bench.servos.missing = {20}
    bench.run(1.1, reply.lease)
    assert last(bench)[0] == "reached"


def test_a_servo_that_is_not_measured_any_more_ends_the_motion_and_holds_where_it_comes_back(bench):
    reply = bench.command(SLOW, duration_s=5.0)
    bench.run(0.3, reply.lease)
    bench.servos.missing = {14}
    bench.run(0.05, reply.lease)
    assert last(bench) == ("fault", "left_knee is not measured: servo 14 does not answer")
    assert bench.goals["left_knee"] is None
    assert "left_knee is not measured" in bench.command(SLOW).reason
    bench.push("left_knee", -0.7)
    bench.servos.missing = set()
    bench.run(0.05)
    assert bench.goals["left_knee"] == pytest.approx(-0.7)


def test_joints_that_do_not_arrive_are_named_with_how_far_they_are_away(bench):
    bench.servos.stuck = {14}
    reply = bench.command({"left_knee": -0.5, "head_yaw": 0.2}, duration_s=0.5)
    bench.run(0.9, reply.lease)
    assert bench.results == []
    bench.run(0.2, reply.lease)
    result, reason = last(bench)
    assert result == "reached"
    assert reason.startswith("over after 1.0")
    assert reason.endswith("but left_knee is 0.50 rad away from its goal")


def test_a_clock_that_goes_back_ends_everything(bench):
    bench.command(SLOW, duration_s=2.0)
    bench.now -= 10.0
    bench.run(DT, hear=False)
    assert last(bench) == ("fault", "the clock went back")
    bench.give(ServosSeen(servos=bench.servos.state(bench.now), arrived=bench.now - 0.1))
    assert bench.state.servos is None, "it came before that"


def test_a_loop_that_was_held_up_goes_on_from_where_it_was(bench):
    reply = bench.command({"left_knee": -1.9}, duration_s=1.0, ttl_s=1.0)
    bench.run(0.3, reply.lease)
    before = bench.goals["left_knee"]
    bench.now += 0.25
    bench.run(DT)
    assert abs(bench.goals["left_knee"] - before) <= 2.0 * 0.051


# torque


def test_torque_comes_on_where_the_joints_are(bench):
    bench.torque(on=False, confirmed=True)
    bench.push("left_knee", -1.2)
    bench.run(0.05)
    assert bench.torque("left_knee", on=True).accepted
    assert bench.goals == {"left_knee": pytest.approx(-1.2)}
    bench.torque(on=True)
    assert set(bench.goals) == set(NAMES)


@pytest.mark.parametrize(("at_rad", "code", "goal_rad"), [(0.18, "", 0.1), (0.25, "limit", None)])
def test_torque_comes_on_at_the_limit_that_a_joint_is_just_beyond_and_not_far_beyond(bench, at_rad, code, goal_rad):
    bench.torque("left_knee", on=False)
    bench.push("left_knee", at_rad)
    bench.run(0.05)
    assert bench.torque("left_knee", on=True).code == code
    assert bench.goals.get("left_knee") == goal_rad


def test_who_switches_the_torque_of_one_joint_off_leaves_the_others_held(bench):
    reply = bench.command(SLOW, duration_s=2.0)
    assert bench.torque("head_yaw", on=False, lease=reply.lease).accepted
    assert not bench.setpoint.lost
    bench.run(1.0)
    assert bench.setpoint.lost
    assert bench.torque("left_knee", on=False).accepted
    assert not bench.setpoint.lost


def test_all_torque_off_is_refused_unless_it_is_meant(bench):
    assert "console switched the torque of all joints on" in {event.text for event in bench.events}
    assert not bench.torque(on=False).accepted
    assert not bench.torque(*NAMES, on=False).accepted
    assert set(bench.goals) == set(NAMES)
    assert bench.torque("left_knee", on=False).accepted
    assert "left_knee" not in bench.goals
    assert bench.torque(on=False, confirmed=True).accepted
    assert bench.goals == {}


def test_torque_is_not_switched_by_others_while_somebody_moves_the_joints(bench):
    reply = bench.command(SLOW, duration_s=2.0)
    assert bench.torque("head_yaw", on=False, source="pad").reason == "held by console; stop it first"
    assert bench.torque("head_yaw", on=False).accepted
    assert bench.torque("right_knee", on=False, source="pad", lease=reply.lease).accepted
    assert bench.torque("left_knee", on=False).accepted
    assert last(bench) == ("fault", "left_knee has no torque any more")


@pytest.mark.parametrize(
    ("joints", "more", "code", "about"),
    [
        (("left_kne",), {}, "unknown_name", ("'left_kne'",)),
        (("left_knee",), {"lease": "old"}, "dead_lease", ("not known",)),
        (("left_knee",), {}, "limit", ("left_knee", "-2.30 rad", "(-2 to 0.1 rad)")),
        (("right_knee",), {}, "latched", ("right_knee", "overload")),
        (("head_yaw",), {}, "stale_sensor", ("head_yaw", "not measured")),
    ],
)
def test_a_joint_that_cannot_be_held_stays_without_torque(joints, more, code, about):
    bench = Bench()
    bench.push("left_knee", -2.3)
    bench.servos.latched, bench.servos.missing = {13: ("overload",)}, {20}
    bench.run(0.05)
    reply = bench.torque(*joints, on=True, **more)
    assert (reply.accepted, reply.code) == (False, code)
    assert all(name in reply.reason for name in about), reply.reason
    others = bench.torque(on=True)
    assert others.accepted
    assert "head_yaw" in others.reason
    assert "more" not in others.reason, "all three are named"
    assert set(bench.goals) == set(NAMES) - {"left_knee", "right_knee", "head_yaw"}


def test_no_torque_comes_on_under_the_emergency_stop(bench):
    bench.torque("left_knee", on=False)
    bench.estop()
    assert bench.torque("left_knee", on=True).reason.startswith("emergency stop")


@pytest.mark.parametrize("phase", ["releasing", "holding"])
def test_servos_that_gave_way_while_nobody_cared_are_held_again_where_they_are_by_then(bench, phase):
    bench.command(SLOW, duration_s=2.0)
    bench.run(0.5)
    bench.servos.phase = phase
    bench.push("left_knee", -0.9)
    bench.hear()
    bench.torque(on=True)
    assert bench.goals["left_knee"] == pytest.approx(-0.9)
    assert not bench.setpoint.lost


def test_a_sweep_of_nothing_is_one_too(bench, wording):
    empty = ServosState(sweep=1, measured_s=bench.now, armed=True, phase="holding", servos=())
    bench.servos.state = lambda now: empty
    bench.command(SLOW)
    bench.run(0.05)
    wording(*last(bench))


def test_a_lease_that_stays_outlives_arrival_until_it_lapses_or_somebody_stops(bench):
    lease = bench.command({"left_knee": -0.3}, join=True, stay=True).lease
    bench.run(3.0, lease)
    assert bench.measured("left_knee") == pytest.approx(-0.3, abs=0.05)
    assert bench.results == []
    assert bench.command({"right_knee": -0.3}, source="web").reason == "held by console; stop it first"
    assert bench.command({"left_knee": -0.1}, join=True, stay=True, lease=lease).accepted
    bench.run(3.0, lease)
    assert bench.measured("left_knee") == pytest.approx(-0.1, abs=0.05)
    bench.stop()
    assert [result.result for result in bench.results] == ["stopped"]
    assert not bench.command({"left_knee": -0.3}, join=True, stay=True, lease=lease).accepted


def test_a_stay_is_over_when_a_later_command_does_not_stay(bench):
    lease = bench.command({"left_knee": -0.3}, join=True, stay=True).lease
    bench.run(2.0, lease)
    bench.command({"left_knee": -0.2}, join=True, lease=lease)
    bench.run(2.0, lease)
    assert [result.result for result in bench.results] == ["reached"]


@pytest.mark.parametrize(
    ("remote", "answerable", "code"), [(True, False, "query_first"), (True, True, ""), (False, False, "")]
)
def test_from_another_machine_torque_is_switched_by_a_query_alone(bench, remote, answerable, code):
    command = TorqueCommand(on=False, joints=("head_yaw",))
    event = Torque(command=command, source="page", received=bench.now, remote=remote, answerable=answerable)
    reply = bench.answer(event)
    assert (reply.accepted, reply.code) == (not code, code)
    assert ("head_yaw" in bench.state.on) is bool(code)


def test_torque_is_not_switched_by_a_command_that_comes_late(bench):
    command = TorqueCommand(on=False, joints=("head_yaw",))
    assert bench.answer(Torque(command=command, source="page", received=bench.now - 0.5)).code == "late"
    assert "head_yaw" in bench.state.on


@pytest.mark.parametrize(
    ("phase", "strengths"), [("holding", {"left_knee": 0.6}), ("following", {"left_knee": 0.6}), ("releasing", {})]
)
def test_servos_that_are_found_with_less_torque_keep_it_unless_they_were_being_released(phase, strengths):
    bench = Bench()
    bench.servos.torque = dict.fromkeys(bench.servos.torque, 1.0) | {14: 0.6, 20: 0.0}
    bench.servos.phase = phase
    bench.hear()
    assert bench.state.on == set(NAMES) - {"head_yaw"}
    assert bench.state.strength == strengths


def test_to_ways_that_joined_as_many_key_frames_may_be_appended_as_to_none(bench):
    lease = bench.command({"left_knee": -1.0}, join=True).lease
    bench.now += 1e-5
    most = (frame(0.02, head_yaw=0.01),) * MAX_FRAMES
    reply = bench.command(frames=most, append=True, lease=lease)
    assert reply.code != "busy", reply.reason
    assert joints_state(bench.state, bench.now).passed == 0
    bench.now += 1e-5
    assert bench.command(frames=most[:1], append=True, lease=lease).code == "busy"


def test_why_the_joints_stand_still_is_in_their_state(bench):
    def said():
        state = joints_state(bench.state, bench.now)
        return state.code, state.reason

    bench.lose_servos()
    assert said()[1] == "the servo driver (servos) is gone"
    bench.run(0.05)
    assert bench.command(SLOW, source="far", remote=True, sender_s=5.0).accepted
    assert said() == ("not_ready", "waiting for far to confirm")
    bench.estop()
    bench.lose_servos()
    assert said() == ("estop", "emergency stop: test")


@pytest.mark.parametrize("torque", [0.0, 1.0])
def test_a_servo_that_was_silent_at_first_counts_once_it_is_heard(torque):
    bench = Bench()
    bench.servos.missing = {20}
    bench.run(0.5)
    assert bench.state.unread == {"head_yaw"}
    bench.servos.torque[20] = torque
    bench.servos.missing = set()
    bench.hear()
    assert bench.state.unread == set()
    assert ("head_yaw" in bench.state.on) is bool(torque)
