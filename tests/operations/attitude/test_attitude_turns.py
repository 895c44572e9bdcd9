"""Turns are watched and told; nothing is ever stopped for them."""

import pytest

from lbr.messages.drive import DriveState


def turn(bench, degrees, rate_dps=50.0):
    bench.drive.lease, bench.drive.power, bench.drive.until_s = "x", rate_dps / 400.0, bench.clock() + 1e9
    bench.run(abs(degrees / rate_dps))
    bench.drive.lease = ""
    bench.run(0.1)


def test_a_turn_is_told_when_it_is_reached_and_nothing_moves_or_stops_for_it(bench):
    assert bench.observe(90.0).answer.accepted
    turn(bench, 85.0)
    assert bench.told("turned") == []
    turn(bench, 10.0)
    (text,) = bench.told("turned")
    assert text.startswith("turned 9")
    assert text.endswith(" s")
    assert bench.drive.commands == bench.drive.stops == []


def test_a_turn_the_other_way_does_not_count(bench):
    bench.observe(-30.0)
    turn(bench, 60.0)
    assert bench.told("turned") == []
    turn(bench, -95.0, -50.0)
    assert bench.told("turned")[0].startswith("turned -3")


def test_several_turns_are_watched_and_too_many_refused(bench):
    for angle in range(10, 170, 10):
        assert bench.observe(float(angle)).answer.accepted
    assert "already" in bench.observe(5.0).answer.reason
    turn(bench, 45.0)
    assert len(bench.told("turned")) == 4


def test_a_turn_is_given_up_after_its_time_or_when_samples_are_missing(bench):
    bench.observe(90.0)
    bench.deaf = True
    bench.run(0.5)
    bench.deaf = False
    bench.run(0.3)
    assert "lost sight of" in bench.told("turn_lost")[0]
    bench.observe(90.0)
    bench.capability._turns._longest_s = 1.0
    bench.run(1.2)
    assert "did not come within 1 s" in bench.told("turn_lost")[1]


def test_what_cannot_be_watched_is_refused_with_the_reason(bench):
    assert "0 degrees" in bench.observe(0.0).answer.reason
    bench.deaf = True
    bench.run(1.0)
    assert "no sample" in bench.observe(10.0).answer.reason


def drives(bench, *, moving):
    bench.arrive(
        "drive",
        DriveState(
            moving=moving,
            power=0.0,
            angle_deg=0.0,
            left=0.0,
            right=0.0,
            holder=None,
            goal=None,
            limited_by="",
            reason="",
            estop=False,
            loop=None,
        ),
    )


def stands(bench, seconds):
    """Let a base stand that says so twice a second, and return the states of that time."""
    before = len(bench.said("state"))
    for _ in range(round(2 * seconds)):
        drives(bench, moving=False)
        bench.run(0.5)
    return bench.said("state")[before:]


def test_a_body_at_rest_is_reported_twice_a_second(bench):
    stands(bench, 1.5)
    states = stands(bench, 4.0)
    assert 7 <= len(states) <= 9
    assert all(state.rests and state.valid for state in states)


def test_a_body_that_stood_while_its_zero_was_learnt_rests_from_the_first_word_of_its_base(bench):
    drives(bench, moving=False)
    bench.run(0.1)
    assert bench.state().rests


@pytest.mark.parametrize("rate_dps", [0.0, 60.0], ids=["the base is to move", "the body is pushed"])
def test_a_motion_is_reported_at_once_and_as_often_as_ever(bench, rate_dps):
    stands(bench, 3.0)
    before = len(bench.said("state"))
    drives(bench, moving=not rate_dps)
    bench.drive.rate_dps = lambda _now: rate_dps
    bench.run(0.1)
    assert [state.rests for state in bench.said("state")[before:]].count(False) >= 1
    bench.run(1.0)
    assert len(bench.said("state")) - before > 10


def test_a_body_whose_base_says_nothing_is_not_at_rest(bench):
    stands(bench, 3.0)
    assert bench.state().rests
    bench.run(1.5)
    assert not bench.state().rests


def test_silence_of_the_inertial_unit_is_reported_at_rest_as_soon_as_ever(bench):
    stands(bench, 3.0)
    bench.deaf = True
    bench.run(0.26)
    assert not bench.state().valid


def test_the_state_is_published_with_reason_and_health_follows(bench):
    assert bench.state().valid
    assert bench.state().still
    bench.deaf = True
    bench.run(1.5)
    assert not bench.state().valid
    assert len(bench.health) == 3
    assert "zero is not known yet" in bench.health[0]
    assert bench.health[1] == "ready"
    assert "no sample" in bench.health[2]
    bench.deaf = False
    bench.run(2.0)
    assert bench.health[-1] == "ready"
    assert bench.state().turned_deg == pytest.approx(0.0, abs=0.3)
