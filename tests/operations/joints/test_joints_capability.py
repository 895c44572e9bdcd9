"""The process around the kernel: what it publishes when, whom it asks, and what it does when things end."""

from math import radians

import msgspec
import pytest

from lbr.capability.stage import Stage, alone
from lbr.messages.joints import TorqueCommand
from lbr.messages.leases import CommandReply
from lbr.operations.joints import KIND
from lbr.operations.joints.capability import Joints
from tests.operations.joints.joints_bench import BODY, NAMES, ROWS
from tests.operations.joints.joints_context import JointsContext, Robot


@pytest.fixture
def robot():
    return Robot().standing()


def test_the_kind_names_the_class_that_runs():
    assert KIND.load() is Joints
    assert KIND.moves
    assert KIND.parse("{}") == JointsContext().settings


@pytest.mark.parametrize(
    ("row", "complaint"),
    [
        ('{"rate_hz": 5}', r"\$.rate_hz"),
        ('{"tolerance": 1}', "unknown field `tolerance`"),
        ('{"ttl_s": 3}', r"\$.ttl_s"),
    ],
)
def test_a_bad_row_is_refused_naming_the_field(row, complaint):
    with pytest.raises(msgspec.ValidationError, match=complaint):
        KIND.parse(row)


def test_setpoints_come_at_the_rate_of_the_loop_however_often_it_is_woken(robot):
    robot.ctx.published.clear()
    for _ in range(500):
        robot.ctx.now += 0.002
        robot.ctx.hear()
        robot.joints.step()
    assert len(robot.ctx.said("setpoint")) == pytest.approx(100, abs=2)
    assert len(robot.ctx.said("state")) == pytest.approx(100, abs=5)


@pytest.fixture
def at_rest(robot):
    robot.ctx.servos.rests = True
    robot.run(0.2)
    robot.ctx.published.clear()
    return robot


def test_at_rest_setpoints_and_states_come_ten_times_a_second(at_rest):
    for step in range(1000):
        at_rest.ctx.now += 0.002
        if step % 50 == 0:
            at_rest.ctx.hear()
        at_rest.joints.step()
    assert len(at_rest.ctx.said("setpoint")) == pytest.approx(20, abs=2)
    assert len(at_rest.ctx.said("state")) == pytest.approx(20, abs=2)
    assert at_rest.joints.rate_hz == 10.0


def test_whatever_is_to_move_has_its_setpoint_at_once_and_then_at_the_full_rate(at_rest):
    now = at_rest.ctx.now
    at_rest.move("left_knee", -30.0)
    assert len(at_rest.ctx.said("setpoint")) == 1
    at_rest.joints.step()
    assert (at_rest.joints.rate_hz, at_rest.ctx.now) == (100.0, now)
    at_rest.run(0.2)
    assert len(at_rest.ctx.said("setpoint")) >= 20


@pytest.mark.parametrize("on", [False, True])
def test_torque_that_is_switched_at_rest_is_in_a_setpoint_with_the_next_step(at_rest, on):
    at_rest.call("torque", TorqueCommand(on=on, joints=("left_knee",), confirmed=True))
    at_rest.joints.step()
    goal = next(one for one in at_rest.setpoint.goals if one.id == BODY.joints["left_knee"].device_id)
    assert (goal.torque > 0.0) is on
    assert at_rest.joints.rate_hz == (10.0 if on else 100.0), "they had torque before"


def test_servos_that_rest_no_longer_are_told_at_the_full_rate_at_once(at_rest):
    at_rest.run(0.05)
    at_rest.ctx.published.clear()
    at_rest.ctx.servos.rests = False
    at_rest.ctx.now += 0.001
    at_rest.ctx.hear()
    at_rest.joints.step()
    assert len(at_rest.ctx.said("setpoint")) == 1
    assert at_rest.joints.rate_hz == 100.0


def test_the_state_is_one_sweep_in_the_joints_own_radians(robot, wording):
    robot.ctx.servos.at[2] = BODY.servo_rad("left_shoulder_pitch", 0.7)
    robot.ctx.servos.stuck, robot.ctx.servos.missing = {2}, {20}
    robot.run(0.02)
    state = robot.state
    assert list(state.joints) == sorted(NAMES)
    assert state.sequence == robot.ctx.servos.sweep
    assert state.joints["left_shoulder_pitch"].position_rad == pytest.approx(0.7)
    assert state.joints["head_yaw"].position_rad is None
    head = state.joints["head_yaw"]
    assert (head.reason, head.code) == ("servo 20 does not answer", "unreachable")
    assert state.joints["left_shoulder_pitch"].code == ""
    assert (state.phase, state.moving, state.holder) == ("following", False, None)
    wording(state.reason)


def test_while_joints_move_their_state_is_told_often_also_of_servos_that_are_read_seldom(robot):
    reply = robot.command({"left_knee": -1.9}, duration_s=5.0)
    robot.ctx.published.clear()
    for step in range(100):
        if step % 10 == 0:
            robot.command(lease=reply.lease)
        robot.run(0.01, hear=step % 7 == 0)
    assert len(robot.ctx.said("state")) >= 20


def test_at_rest_their_state_is_told_ten_times_a_second_also_of_servos_that_are_read_seldom(robot):
    robot.run(0.5)
    robot.ctx.published.clear()
    robot.run(0.65, hear=False)
    assert 5 <= len(robot.ctx.said("state")) <= 8


def test_a_motion_is_shown_while_it_goes_on_and_its_result_published(robot):
    reply = robot.move("left_knee", -30.0, speed_dps=60.0)
    assert reply.accepted
    robot.run(0.3, reply.lease)
    assert (robot.state.moving, robot.state.holder, robot.state.goal) == (True, "console", reply.goal)
    robot.run(0.6, reply.lease)
    (result,) = robot.ctx.said("result")
    assert (result.goal, result.result) == (reply.goal, "reached")
    assert robot.state.joints["left_knee"].position_rad == pytest.approx(radians(-30.0), abs=1e-4)
    assert not robot.state.moving


def test_a_stop_is_in_a_setpoint_before_it_is_answered(robot):
    reply = robot.move("left_knee", -60.0)
    robot.run(0.3, reply.lease)
    halt = robot.setpoint.halt
    robot.ctx.published.clear()
    assert robot.stop().accepted
    (setpoint,) = robot.ctx.said("setpoint")
    assert setpoint.halt != halt
    assert robot.ctx.said("result")[-1].reason == "stopped by phone: test"


def test_the_emergency_stop_is_acknowledged_once_the_driver_holds(robot):
    robot.move("left_knee", -60.0)
    robot.ctx.estop.engaged, robot.ctx.estop.reason = True, "test"
    robot.run(0.03, hear=False)
    assert robot.ctx.estop.acknowledged[-1][0] is False
    robot.ctx.servos.estop, robot.ctx.servos.phase = True, "holding"
    robot.run(0.02)
    assert robot.ctx.estop.acknowledged[-1][0] is True
    assert robot.state.reason == "emergency stop: test"
    robot.ctx.estop.engaged = robot.ctx.servos.estop = False
    where = robot.setpoint.goals
    robot.run(0.1)
    assert robot.setpoint.goals == where


def test_they_are_ready_once_the_servos_are_armed_and_it_is_known_which_have_torque():
    robot = Robot()
    robot.run(0.05, hear=False)
    assert robot.joints.lacks().code == "not_ready"
    robot.ctx.servos.armed = False
    robot.run(0.05)
    assert robot.joints.lacks().code == "not_armed"
    robot.ctx.servos.armed = True
    robot.run(0.05)
    assert robot.joints.lacks() is None
    assert robot.call("torque", TorqueCommand(on=True)).accepted


def test_a_driver_that_is_gone_has_nothing_to_acknowledge(robot):
    robot.ctx.gone.add("servos")
    robot.ctx.estop.engaged = True
    robot.run(0.02, hear=False)
    assert robot.ctx.estop.acknowledged[-1][0] is True
    assert robot.state.joints["left_knee"].position_rad is None
    assert "is gone" in robot.state.joints["left_knee"].reason
    assert robot.state.joints["left_knee"].code == "unreachable"


def test_a_holder_whose_process_dies_is_lost(robot):
    reply = robot.command({"left_knee": -1.0}, source="motions", duration_s=5.0)
    robot.run(0.1, reply.lease)
    robot.ctx.gone.add("motions")
    robot.run(0.01)
    assert robot.setpoint.lost
    assert robot.ctx.said("result")[-1].reason == "the process of motions is gone"


def test_that_torque_is_not_switched_is_told_to_people_too_not_to_its_sender_alone():
    stage = Stage()
    stage.add(alone(KIND, rows=ROWS, name="joints"))
    reply = stage.answer("joints", "torque", TorqueCommand(on=True), "console")
    stage.round()
    assert not reply.accepted
    assert reply.code in {one.code for one in stage.told if one.kind == "refused"}


def test_recovering_is_asked_of_the_driver_and_answered_when_it_has(robot):
    call = robot.recover("left_knee")
    assert robot.ctx.asked[-1].message.ids == (14,)
    robot.run(0.5)
    assert call.answer is None
    robot.ctx.asked[-1].given = {"servos": CommandReply(accepted=True, reason="recovered servo 14")}
    robot.run(0.01)
    assert call.answer == CommandReply(accepted=True, reason="recovered servo 14")


@pytest.mark.parametrize("answers", [{}, {"servos": None}, {"servos": CommandReply(accepted=True), "others": None}])
def test_a_driver_that_does_not_answer_is_told_of(robot, answers):
    call = robot.recover()
    assert len(robot.ctx.asked[-1].message.ids) == len(NAMES)
    robot.ctx.asked[-1].given = answers
    robot.run(0.01)
    assert (call.answer.accepted, call.answer.code) == (False, "unreachable")


def test_an_unknown_joint_is_not_recovered(robot):
    assert robot.recover("left_kne").answer.reason.startswith("there is no joint 'left_kne'")
    assert robot.ctx.asked == []


def test_what_is_closed_before_it_was_opened_tells_the_servos_nothing():
    ctx = JointsContext()
    Joints(ctx).close()
    assert ctx.said("setpoint") == []


def test_ending_holds_every_joint_and_says_that_the_mover_is_gone(robot):
    reply = robot.move("left_knee", -60.0)
    robot.run(0.3, reply.lease)
    call = robot.recover()
    robot.joints.close()
    assert robot.setpoint.lost
    assert {goal.torque for goal in robot.setpoint.goals} == {1.0}
    assert robot.ctx.said("result")[-1].result == "stopped"
    assert not call.answer.accepted
