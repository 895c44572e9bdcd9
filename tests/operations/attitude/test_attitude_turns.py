"""Turns are watched and told; nothing is ever stopped for them."""

from math import degrees, radians

import pytest
from msgspec.structs import replace

from lbr.messages.drive import DriveState
from lbr.operations.motions.fall import Fall, seen
from tests.operations.attitude.attitude_context import AttitudeContext
from tests.operations.attitude.imu_bench import MadeUpImu


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


@pytest.fixture
def legs(tmp_path):
    """Return the attitude of a body without a base."""
    return on_legs(tmp_path)


def on_legs(tmp_path, pitch_deg=0.0):
    context = AttitudeContext(tmp_path, LeaningImu(pitch_deg=pitch_deg), {"drive": (), "motion": ()})
    context.run(1.5)
    return context


class LeaningImu(MadeUpImu):
    """Leans ahead by `lean_dps`."""

    lean_dps = 0.0

    def sample(self, clockwise_dps=0.0, *, mag=True):
        self.pitch_deg += self.lean_dps / self.rate_hz
        sample = super().sample(clockwise_dps, mag=mag)
        x, y, z = sample.gyro_rps
        return replace(sample, gyro_rps=(x, y + radians(self.lean_dps), z))


def falls_s(bench, lean_dps):
    """Let the body fall to 80 degrees, and return after how long motions know of it by the reported states."""
    fall, began_s, bench.imu.lean_dps = Fall(), bench.clock(), lean_dps
    while not fall.lies and bench.clock() - began_s < 10.0:
        bench.run(0.02)
        fall = seen(fall, bench.state(), bench.clock())
        bench.imu.lean_dps = lean_dps if bench.imu.pitch_deg < 80.0 else 0.0
    return bench.clock() - began_s


def test_a_body_without_a_base_that_stands_is_reported_twice_a_second(legs):
    legs.run(2.0)
    before = len(legs.said("state"))
    legs.run(4.0)
    states = legs.said("state")[before:]
    assert 7 <= len(states) <= 9
    assert all(state.rests and state.valid for state in states)


@pytest.mark.parametrize("pitch_deg", [50.0, 89.0, -60.0])
def test_a_body_that_lies_or_leans_far_is_reported_as_often_as_ever(tmp_path, pitch_deg):
    legs = on_legs(tmp_path, pitch_deg)
    legs.run(3.0)
    before = len(legs.said("state"))
    legs.run(2.0)
    assert len(legs.said("state")) - before > 20
    assert not legs.state().rests


@pytest.mark.parametrize("lean_dps", [95.0, 40.0])
def test_a_fall_is_known_as_soon_from_a_rest_as_without_one(legs, lean_dps):
    legs.run(3.0)
    assert legs.state().rests
    assert 60.0 / lean_dps + 0.2 <= falls_s(legs, lean_dps) <= 60.0 / lean_dps + 0.2 + 0.08


def test_a_body_that_leans_slower_than_a_turn_counts_is_watched_before_it_is_a_fall(tmp_path):
    legs = on_legs(tmp_path, 40.0)
    legs.run(3.0)
    assert legs.state().rests
    legs.imu.lean_dps = 1.0
    legs.run(10.0)
    assert not legs.state().rests
    assert abs(degrees(legs.state().pitch_rad) - legs.imu.pitch_deg) < 3.0


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
