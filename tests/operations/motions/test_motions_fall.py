"""A fall is known by how the trunk leans for a while, and upright again likewise; and it ends what is played."""

from math import nan, pi

import pytest

from lbr.messages.attitude import AttitudeState
from lbr.operations.motions.fall import Fall, seen


def lean(roll=0.0, pitch=0.0, at=0.0, **more):
    return AttitudeState(
        **{"valid": True, "epoch": "e", "measured_s": at, "roll_rad": roll, "pitch_rad": pitch, **more}
    )


def after(state, seconds, begun=0.0, **how):
    for tick in range(round(seconds / 0.02) + 1):
        now = begun + tick * 0.02
        state = seen(state, lean(at=now, **how), now)
    return state


@pytest.mark.parametrize(
    ("how", "lies"),
    [
        ({"pitch": 1.5}, "face"),
        ({"pitch": -1.5}, "back"),
        ({"roll": 1.5}, "side"),
        ({"roll": pi, "pitch": 1.4}, "face"),
        ({"pitch": 0.9}, ""),
        ({"pitch": nan}, ""),
        ({"pitch": 1.5, "valid": False}, ""),
        ({"pitch": 1.5, "at_": 0}, ""),
    ],
)
def test_where_it_lies(how, lies):
    if how.pop("at_", None) == 0:
        assert seen(Fall(since=0.0), lean(pitch=1.5, at=0.0), 5.0).lies == "", "an old attitude says nothing"
        return
    assert after(Fall(), 0.3, **how).lies == lies


@pytest.mark.parametrize(("rests", "lies"), [(True, "face"), (False, "")])
def test_a_body_at_rest_is_known_by_older_states(rests, lies):
    at_rest = lean(pitch=1.5, rests=rests)
    assert seen(seen(Fall(), at_rest, 0.0), at_rest, 0.4).lies == lies
    assert seen(seen(Fall(), at_rest, 0.0), at_rest, 1.3).lies == ""


def test_a_knock_is_no_fall_and_it_is_upright_again_after_a_while():
    assert after(after(Fall(), 0.1, pitch=1.5), 0.1, 0.12).lies == ""
    down = after(Fall(), 0.3, pitch=1.5)
    assert after(down, 0.3, 1.0).lies == "face"
    assert after(after(down, 0.3, 1.0), 0.6, 1.32).lies == ""
    assert after(down, 0.1, 1.0, pitch=-1.5).lies == "back", "it was turned over"


def test_a_fall_ends_what_is_played_at_once_is_told_and_shown_and_only_what_gets_it_up_is_played_lying(
    stage, world, wording
):
    call = stage.begun("walk", times=3)
    stage.run(0.3, call)
    world.pitch_rad = 1.5
    stage.run(0.3, call)
    wording(*world.body.halts)
    assert world.body.at_once
    (result,) = world.said("result")
    assert (result.result, result.code) == ("fault", "fallen")
    wording(result)
    assert (world.state.playing, world.state.fallen) == (False, "face")
    assert ("fallen", "bioloid has fallen, it lies on its face") in [(one[0], one[1]) for one in world.events]
    for lying, code in (("wave", "fallen"), ("walk", "fallen"), ("get_up_face", "")):
        again = stage.begun(lying)
        assert (again.answer.accepted, again.answer.code) == (not code, code)
    stage.run(2.0, again)
    assert world.said("result")[-1].result == "reached"
    world.pitch_rad = 0.0
    stage.run(0.6)
    assert world.state.fallen == ""
    assert stage.begun("wave").answer.accepted


@pytest.mark.parametrize("steps", [True, False])
def test_a_fall_on_the_way_to_its_feet_holds_the_joints_at_once(stage, world, steps):
    """What was stopped in mid-step has no holder any more, and goes on for up to 0.8 s; not while it lies."""
    world.body.feet_s = 0.7 if steps else None
    stage.run(0.1)
    world.pitch_rad = 1.5
    stage.run(0.4)
    assert len(world.body.halts) == steps
    assert not steps or world.body.at_once
