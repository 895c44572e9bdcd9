"""Playing: what is sent to the joints, for whom, and how it ends."""

import pytest

from lbr.messages.joints import Motion
from tests.operations.motions.motions_bench import frame


def positions(world):
    return [one.positions for one in world.body.frames]


def test_a_motion_is_sent_as_one_command_and_reaches_its_end(stage, world):
    call = stage.begun("wave")
    assert call.answer.accepted
    assert call.answer.ttl_s == 0.3
    assert positions(world) == [{"right_elbow": -0.2}, {"right_elbow": -0.4}, {"right_elbow": -0.3}]
    stage.run(2.0, call)
    (result,) = world.said("result")
    assert (result.goal, result.result) == (call.answer.goal, "reached")
    assert result.reason == "'wave' was played to its end in 1.5 s"
    assert world.body.halts == []
    assert not world.state.playing
    assert world.state.reason == result.reason


def test_its_loop_is_slow_until_a_motion_begins_and_again_once_it_has_ended(stage):
    stage.run(0.1)
    assert stage.motions.rate_hz == 10.0
    call = stage.begun("wave")
    stage.run(0.02)
    assert stage.motions.rate_hz == 50.0
    stage.run(2.0, call)
    assert stage.motions.rate_hz == 10.0


def test_its_lease_on_the_joints_is_renewed_ten_times_a_second_without_the_key_frames(stage, world):
    stage.run(1.0, stage.begun("wave"))
    first, *renewals = world.body.commands
    assert len(first.frames) == 3
    assert 8 <= len(renewals) <= 11
    assert all(not one.frames and not one.positions and one.lease == "lease-1" for one in renewals)


def test_lead_in_and_lead_out_are_played_once_around_all_rounds_without_a_pause(stage, world):
    call = stage.begun("walk", times=3)
    walk, ready = [{"neck": 0.1}, {"neck": -0.1}], [{"right_elbow": -0.1, "left_elbow": -0.1}]
    assert positions(world) == [*ready, *(walk * 3), *ready]
    assert len([one for one in world.body.commands if one.frames]) == 1
    stage.run(5.0, call)
    assert world.said("result")[0].reason == "'walk' was played 3 times to its end in 4.0 s"
    places = {(one.motion, one.frame, one.frames, one.round, one.times) for one in world.said("state") if one.playing}
    assert {("ready", 1, 1, 1, 3), ("walk", 1, 2, 1, 3), ("walk", 2, 2, 3, 3), ("ready", 1, 1, 3, 3)} <= places
    assert {one.holder for one in world.said("state") if one.playing} == {"console"}


def test_speed_scales_durations_and_mirror_is_the_joints_business(stage, world):
    stage.begun("wave", speed=2.0, mirror=True)
    assert [one.duration_s for one in world.body.frames] == [0.25, 0.25, 0.25]
    assert world.body.commands[0].mirror


def test_many_rounds_are_sent_ahead_so_that_they_flow(stage, world):
    call = stage.begun("walk", times=200)
    assert len(world.body.frames) == 50
    stage.run(30.0, call)
    sent = [one for one in world.body.commands if one.frames]
    assert len(sent) == 2
    assert sent[1].append
    assert len(world.body.frames) == 100
    assert positions(world)[1:] == [{"neck": 0.1}, {"neck": -0.1}] * 49 + [{"neck": 0.1}]
    assert world.said("result") == []
    assert world.state.round > 20


def test_the_way_to_the_first_key_frame_takes_as_long_as_the_slowest_joint_needs(stage, world):
    world.pose["left_elbow"] = -1.9
    stage.begun("ready")
    assert world.body.frames[0].duration_s == pytest.approx(1.5 * 1.8 / 3.0)
    stage.stop()
    world.pose |= {"left_elbow": -0.1, "right_elbow": -1.9}
    stage.begun("wave", mirror=True)
    assert world.body.frames[0].duration_s == 0.5  # it is the left one that waves


def test_the_player_that_renews_no_more_stops_the_motion(stage, world, wording):
    call = stage.begun("wave")
    stage.run(0.5)
    (result,) = world.said("result")
    assert result.result == "lapsed"
    wording(*world.body.halts)
    assert world.body.lost
    late = stage.play("wave", lease=call.answer.lease)
    wording(late.answer)
    stage.run(0.5)
    assert world.body.holder == ""


def test_anyone_may_stop(stage, world):
    call = stage.begun("walk", times=3)
    stage.run(0.7, call)
    assert stage.stop("phone", "enough").answer.accepted
    stage.run(1.0, call)
    assert world.said("result")[0].result == "stopped"
    assert world.said("result")[0].reason == "stopped by phone: enough"
    assert world.body.halts == ["stopped by phone: enough"]
    assert {"right_elbow": -0.1, "left_elbow": -0.1} not in positions(world)[1:-1]
    assert world.body.holder == ""


def test_a_second_player_is_told_who_plays_unless_it_takes_over(stage, world):
    first = stage.begun("wave")
    assert stage.play("walk", source="pad").answer.reason == (
        "busy: 'wave' is played by console; stop it, or take over"
    )
    second = stage.begun("walk", source="pad", take_over=True)
    assert second.answer.accepted
    assert second.answer.lease != first.answer.lease
    assert [(one.goal, one.result) for one in world.said("result")] == [(first.answer.goal, "superseded")]
    assert world.body.commands[-1].lease == "lease-1"  # of the same joints, without a gap
    assert world.body.halts == []
    stage.run(3.0, second, source="pad")
    assert world.said("result")[-1].goal == second.answer.goal
    assert world.said("result")[-1].result == "reached"


def test_the_holder_goes_on_with_another_motion_under_its_lease(stage, world):
    first = stage.begun("wave")
    second = stage.begun("ready", lease=first.answer.lease)
    assert second.answer.lease == first.answer.lease
    assert second.answer.goal != first.answer.goal
    stage.run(1.0, second)
    assert [one.result for one in world.said("result")] == ["superseded", "reached"]


def test_what_the_joints_refuse_is_refused_with_their_reason(stage, world):
    world.body.refusal = "right_elbow has no torque: torque on first"
    call = stage.begun("wave")
    assert not call.answer.accepted
    assert call.answer.reason == "right_elbow has no torque: torque on first"
    assert not world.state.playing
    world.body.refusal = ""
    assert stage.begun("wave").answer.accepted


def test_a_change_that_the_joints_refuse_ends_what_went_before(stage, world):
    first = stage.begun("wave")
    world.body.refusal = "neck is faulty"
    second = stage.begun("walk", lease=first.answer.lease)
    assert second.answer.reason == "neck is faulty"
    stage.run(0.3)
    assert world.body.holder == ""
    assert not world.state.playing


@pytest.mark.parametrize(
    ("how", "why", "result"),
    [
        ("stopped", "stopped by phone", "stopped"),
        ("fault", "right_elbow has latched overload", "fault"),
        ("superseded", "taken over by pad", "superseded"),
        ("lapsed", "it lapsed", "fault"),
    ],
)
def test_it_ends_as_the_joints_ended_and_halts_nobody_else(stage, world, how, why, result):
    call = stage.begun("wave")
    stage.run(0.3, call)
    world.body.end(how, why)
    stage.run(0.5, call)
    assert [(one.result, one.reason) for one in world.said("result")] == [(result, why)]
    assert world.body.halts == []
    assert world.body.holder == ""


def test_a_joint_that_did_not_get_there_is_told_with_the_end(stage, world):
    call = stage.begun("wave")
    stage.run(0.3, call)
    world.body.end("reached", "over after 2.00 s, but right_elbow is 0.30 rad away from its goal")
    stage.run(0.1, call)
    assert world.said("result")[0].reason.endswith(" s, but right_elbow is 0.30 rad away from its goal")


def test_joints_that_fall_silent_or_die_end_it_and_nothing_resumes(stage, world):
    call = stage.begun("walk", times=20)
    stage.run(0.3, call)
    world.body.silent = True
    stage.run(1.0, call)
    assert world.said("result")[0].result == "fault"
    assert "does not answer" in world.said("result")[0].reason
    world.body.silent = False
    stage.run(1.0)
    assert not world.state.playing
    world.body.end("lapsed", "")
    call = stage.begun("wave")
    world.gone.add("joints")
    stage.run(0.5, call)
    assert "joints operation (joints) is not running" in world.said("result")[-1].reason
    assert stage.play("wave").answer.reason == "joints operation (joints) is not running"


def test_a_player_whose_process_dies_stops_at_once(stage, world):
    world.gone.discard("power")
    stage.begun("wave", source="power", ttl_s=1.0)
    world.gone.add("power")
    stage.run(0.1)
    assert world.said("result")[0].reason == "the process of power is gone"
    assert world.body.lost
    assert world.body.holder == ""


def test_the_emergency_stop_ends_it_and_is_acknowledged(stage, world):
    call = stage.begun("wave")
    world.estop.engaged, world.estop.reason = True, "test"
    stage.run(0.1, call)
    assert world.said("result")[0].reason == "emergency stop: test"
    assert world.estop.acknowledged
    assert "emergency stop" in stage.play("wave").answer.reason
    world.estop.engaged = False
    stage.run(0.5)
    assert not world.state.playing
    assert stage.begun("wave").answer.accepted


def test_from_another_machine_nothing_moves_before_the_lease_is_quoted(stage, world):
    offered = stage.play("wave", source="laptop", remote=True, sender_s=7.0)
    assert offered.answer.accepted
    assert world.body.commands == []
    stage.run(0.1)
    confirmed = stage.play("wave", source="laptop", remote=True, sender_s=7.101, lease=offered.answer.lease)
    stage.run(0.1)
    assert confirmed.answer.accepted
    assert confirmed.answer.goal == offered.answer.goal
    assert world.body.holder == "motions"


def test_a_stop_of_the_joints_takes_back_what_was_offered_before(stage, world):
    offered = stage.play("wave", source="laptop", remote=True, sender_s=7.0)
    world.body.why_dead = "stopped by phone"
    world.body.stop(world.now, "stopped by phone")
    stage.run(0.1)
    confirmed = stage.play("wave", source="laptop", remote=True, sender_s=7.101, lease=offered.answer.lease)
    assert confirmed.answer.reason == "lease is dead: stopped by phone"
    assert world.body.commands == []
    assert stage.begun("wave").answer.accepted


def test_what_was_asked_for_before_a_stop_of_the_joints_does_not_begin_after_it(stage, world):
    world.told_of_joints = False  # motions do not know of the stop yet
    world.body.stop(world.now + 0.005, "stopped by phone")
    assert stage.begun("wave").answer.code == "stopped"
    world.now += 0.1
    assert stage.begun("wave").answer.accepted
    world.told_of_joints = True
    stage.run(0.1)
    assert world.state.playing


def test_a_lease_whose_joints_are_lost_begins_nothing_else(stage, world):
    call = stage.begun("wave")
    stage.run(0.1, call)
    world.told_of_joints = False
    world.body.stop(world.now, "stopped by phone")
    world.body.results.clear()  # how it ended is still on its way when the lease is found dead
    stage.run(0.12)
    assert world.state.playing
    refused = stage.play("walk", lease=call.answer.lease)
    assert refused.answer.reason == "lease is dead: stopped by phone"
    assert world.said("result")[0].result == "stopped"


@pytest.mark.parametrize(
    "command",
    [
        {"motion": "waves"},
        {"motion": "empty"},
        {"motion": "slow", "speed": 0.1},
        {"motion": "broken"},
        {"motion": "still"},
    ],
)
def test_what_cannot_be_played_is_refused_and_nothing_moves(stage, world, command, wording):
    motions = (
        Motion(name="slow", frames=(frame(10.0, neck=0.1),)),
        Motion(name="broken", frames=(frame(neck=0.1),), lead_in="gone"),
        Motion(name="still", frames=(frame(),)),
    )
    world.learn(*(row for motion in motions for row in motion.rows))
    wording(stage.play(**command).answer)
    stage.run(0.1)
    assert world.body.commands == []


def test_it_must_be_wired_to_one_joints_operation(stage, world):
    world.asked_joints = ()
    call = stage.begun("wave")
    assert "'move' must be wired to one joints operation" in call.answer.reason


def test_two_players_in_one_moment_get_one_answer_each(stage, world):
    world.body.silent = True
    first = stage.play("wave", source="pad")
    second = stage.play("walk", take_over=True)
    assert first.answer.reason == "taken over by console"
    assert second.answer is None
    stage.run(1.5)
    assert second.answer.reason == "'joints' does not answer"
    assert not world.state.playing


def test_closing_halts_the_joints(stage, world):
    stage.begun("wave")
    stage.motions.close()
    assert world.body.holder == ""
    assert world.said("result")[0].result == "stopped"
