"""Motions that the robot's own controller keeps: played as they are, one after the other, and beside key frames."""

import pytest

from lbr.messages.joints import StoredMotion

STAND = StoredMotion(slot=7, duration_s=2.0, pose={"neck": 0.0, "right_elbow": -0.1})
SIT = StoredMotion(slot=21, duration_s=1.0, limp=True)


def sent(world):
    """What the joints were given to do, in turn: of key frames, how many."""
    doing = [one for one in world.body.commands if one.frames or one.stored]
    return [one.stored or len(one.frames) for one in doing]


def test_a_motion_of_the_controller_is_played_by_its_slot_and_leads_to_the_pose_of_its_rows(stage, world):
    call = stage.begun("stand")
    assert call.answer.accepted
    assert sent(world) == [STAND]
    stage.run(1.0, call)
    state = world.state
    assert (state.motion, state.frame, state.frames) == ("stand", 1, 1)
    assert state.left_s == pytest.approx(1.0, abs=0.6)
    stage.run(1.5, call)
    (result,) = world.said("result")
    assert (result.goal, result.result) == (call.answer.goal, "reached")
    assert world.body.halts == []
    assert world.state.left_s is None


def test_it_is_played_again_after_each_end_as_often_as_was_asked_for(stage, world):
    call = stage.begun("sit", times=3)
    stage.run(3.6, call)
    assert sent(world) == [SIT] * 3
    assert world.said("result")[-1].reason.startswith("'sit' was played 3 times to its end")
    assert {one.round for one in world.said("state") if one.playing} == {1, 2, 3}


def test_key_frames_lie_between_a_lead_in_and_a_lead_out_of_the_controller(stage, world):
    call = stage.begun("greet", times=2)
    stage.run(6.0, call)
    assert sent(world) == [STAND, 4, SIT]
    assert [result.result for result in world.said("result")] == ["reached"]
    places = {(one.motion, one.frame, one.round) for one in world.said("state") if one.playing}
    assert {("stand", 1, 1), ("greet", 1, 1), ("greet", 2, 2), ("sit", 1, 2)} <= places


@pytest.mark.parametrize(
    ("motion", "more"),
    [
        ("stand", {"speed": 2.0}),
        ("stand", {"mirror": True}),
        ("greet", {"speed": 0.5}),
        ("endless", {}),
    ],
)
def test_what_the_controller_keeps_is_played_as_it_is_or_not_at_all(stage, world, motion, more, wording):
    reply = stage.play(motion, **more).answer
    wording(reply)
    assert world.body.commands == []


def test_a_stop_between_two_of_them_begins_no_other(stage, world):
    call = stage.begun("sit", times=2)
    stage.run(0.9, call)
    assert stage.stop().answer.accepted
    assert world.body.halts
    stage.run(2.0, call)
    assert sent(world) == [SIT]


@pytest.mark.parametrize("how", ["stop", "held"])
def test_joints_that_are_stopped_or_taken_at_the_end_of_one_do_not_begin_the_next(stage, world, how):
    call = stage.begun("sit", times=2)
    stage.run(0.9, call)
    if how == "stop":
        world.body.stop(world.now, "stopped by phone")
    else:
        world.body.refusal = "held by pad"
        world.body.holder, world.body.why_dead = "pad", "taken over by pad"
        world.body.end("superseded", "taken over by pad")
        world.body.holder = "pad"
    stage.run(2.0, call)
    assert sent(world) == [SIT]
    assert world.said("result")[-1].result in {"stopped", "superseded"}


@pytest.mark.parametrize("who", ["motions", "joints"])
def test_what_was_stopped_is_told_as_stopped_whichever_of_the_two_hears_of_it_first(stage, world, who):
    call = stage.begun("stand")
    stage.run(1.0, call)
    goal = world.body.goal
    if who == "motions":
        assert stage.stop().answer.accepted
    else:
        world.body.stop(world.now, "stopped by phone")
    stage.run(0.2)
    world.body.goal = goal
    world.body.end("reached", "slot 7 was played in 2.00 s")
    stage.run(1.0)
    assert [(one.goal, one.result, one.reason) for one in world.said("result")] == [
        (call.answer.goal, "stopped", "stopped by phone")
    ]
