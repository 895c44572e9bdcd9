"""Moves of a distance: how near to it they end, and what ends them sooner."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.messages.drive import DriveCommand
from lbr.operations.drive import distance_goal
from lbr.operations.drive.odometry_view import OdometryView
from lbr.operations.drive.settings import DriveSettings
from tests.operations.drive.drive_body import Body

STILL = (0.0, 0.0)


@pytest.fixture
def body():
    return Body()


def driving(body, power=0.4, angle_deg=0.0, ticks=20, **more):
    """Begin to drive a distance and go on for a while."""
    command = {"power": power, "angle_deg": angle_deg, "distance_cm": 200.0, **more}
    reply = body.drive(**command)
    assert reply.accepted, reply.reason
    go_on(body, reply, command, ticks)
    assert body.wheels != STILL
    return reply, command


def go_on(body, reply, command, ticks):
    for tick in range(ticks):
        if tick % 5 == 0:
            body.noise_m = 0.001
            body.sense()
            body.drive(**command, lease=reply.lease)
        body.step()


@pytest.mark.parametrize(("distance_cm", "on"), [(34.0, False), (35.0, True)])
def test_a_base_rolls_out_over_what_it_needs_to_brake_and_may_roll_the_other_way_as_far(distance_cm, on):
    command = DriveCommand(power=0.4, distance_cm=distance_cm)
    settings = DriveSettings(brake_mps2=1.5, reaction_s=0.3, distance_tolerance_m=0.02)
    at_speed = OdometryView(trouble="", distance_m=0.0, speed_mps=1.0, seen=10.0)
    way = distance_goal.start(command, at_speed, settings)
    assert (distance_goal.power(way, 0.4, settings, 10.0) > 0.0) is on
    assert way.backward_m == pytest.approx(distance_goal.WRONG_M + 0.3 + 1.0 / 3.0)


@pytest.mark.parametrize(("angle_deg", "sense"), [(0.0, 1.0), (180.0, -1.0), (-180.0, -1.0), (360.0, 1.0)])
@pytest.mark.parametrize(("power", "distance_cm"), [(0.2, 5.0), (0.4, 100.0), (1.0, 300.0)])
def test_a_distance_ends_where_it_should_and_tells_its_error(body, power, distance_cm, angle_deg, sense):
    body.noise_m = 0.001
    result = body.driven(power, angle_deg, distance_cm)
    assert result.result == "reached"
    assert result.distance_m == pytest.approx(sense * distance_cm / 100, abs=0.03)
    assert result.error_m == pytest.approx(abs(result.distance_m) - distance_cm / 100, abs=0.002)
    assert result.distance_m == pytest.approx(body.way_m, abs=0.005)
    assert f" of {distance_cm / 100:g} m in {result.elapsed_s:.1f} s, " in result.reason


@given(
    distance_cm=st.floats(3.0, 150.0), power=st.floats(0.2, 1.0), lazy=st.floats(0.0, 0.85), gain=st.floats(0.5, 1.3)
)
def test_bases_of_all_sorts_end_near_the_end(distance_cm, power, lazy, gain):
    body = Body(lazy=lazy)
    body.gain, body.noise_m = gain, 0.001
    result = body.driven(power, 0.0, distance_cm)
    assert result.result == "reached"
    assert abs(result.error_m) < 0.08


@pytest.mark.parametrize(
    ("command", "odometry", "code", "about"),
    [
        ({"angle_deg": 45.0}, {}, "bad_value", ("distance_cm", "angle_deg", "45")),
        ({"angle_deg": 90.0}, {}, "bad_value", ("distance_cm", "angle_deg", "90")),
        ({}, {"valid": False, "reason": "no encoders"}, "stale_sensor", ("odometry", ": no encoders")),
        ({}, {"distance_m": None}, "stale_sensor", ("odometry", "no sense")),
        ({}, {"speed_mps": nan}, "stale_sensor", ("odometry", "no sense")),
        ({}, {"counted_s": None}, "stale_sensor", ("odometry", "no sense")),
        ({}, {"counted_s": 99.0}, "stale_sensor", ("odometry", "older", "0.3 s")),
        ({"distance_cm": nan}, {}, "bad_value", ("distance_cm nan", "0 to 10000")),
        ({"distance_cm": inf}, {}, "bad_value", ("distance_cm inf", "0 to 10000")),
        ({"distance_cm": -1.0}, {}, "bad_value", ("distance_cm -1", "0 to 10000")),
    ],
)
def test_a_distance_that_cannot_be_driven_is_refused_with_its_reason(body, command, odometry, code, about):
    body.odometry = odometry
    body.run(0.4)
    body.tell()
    reply = body.drive(**{"power": 0.3, "distance_cm": 100.0} | command)
    assert (reply.accepted, reply.code) == (False, code)
    assert all(name in reply.reason for name in about), reply.reason


def silence(body):
    body.odometry_speaks = False


@pytest.mark.parametrize(
    ("how", "code", "about"),
    [
        (silence, "stale_sensor", ("odometry", "older", "0.3 s")),
        (lambda b: b.odometry.update(valid=False, reason="no counts"), "stale_sensor", ("odometry", ": no counts")),
        (lambda b: b.odometry.update(epoch="o2"), "stale_sensor", ("odometry", "started over")),
        (lambda b: b.odometry.update(distance_m=nan), "stale_sensor", ("odometry", "no sense")),
        (lambda b: b.odometry.update(distance_m=9.0), "stale_sensor", ("odometry", "jumped")),
        (lambda b: b.odometry.update(stalled=True), "stuck", ("wheels",)),
        (lambda b: setattr(b, "side", -1.0), "not_followed", ("wheels", "signs")),
    ],
)
def test_what_ends_a_distance_is_a_fault_with_a_sentence(body, how, code, about):
    reply, command = driving(body, ticks=10)
    how(body)
    go_on(body, reply, command, 60)
    assert body.wheels == STILL
    (result,) = body.results
    assert (result.result, result.code) == ("fault", code)
    assert all(name in result.reason for name in about), result.reason
    assert not body.drive(**command, lease=reply.lease).accepted


def test_wheels_too_slow_to_move_before_an_obstacle_are_told_by_the_obstacle(body):
    reply, command = driving(body, ticks=10)
    body.see(forward=0.4)
    go_on(body, reply, command, 5)
    body.odometry.update(stalled=True)
    go_on(body, reply, command, 60)
    (result,) = body.results
    assert (result.result, result.code) == ("fault", "obstacle")
    assert "forward" in result.reason
    assert body.wheels == STILL


def test_slipping_wheels_are_told_once_and_the_way_goes_on(body):
    body.odometry = {"slipping": True}
    driving(body)
    (told,) = [event for event in body.events if event.kind == "slip"]
    assert "the wheels slip" in told.text


def test_whichever_bound_comes_first_ends_the_move(body):
    body.noise_m = 0.001
    first = body.driven(0.4, 0.0, 50.0, interval_s=10.0)
    assert (first.result, first.distance_m) == ("reached", pytest.approx(0.5, abs=0.03))
    body.run(0.3)
    body.tell()
    second = body.driven(0.4, 0.0, 900.0, interval_s=0.5)
    assert (second.result, 0.05 < second.distance_m < 0.3) == ("interval", True)
    assert second.error_m == pytest.approx(second.distance_m - 9.0, abs=0.002)


def test_a_range_ends_a_distance_too(body):
    body.see(forward=0.9)
    driving(body, range_cm=60.0)
    body.see(forward=0.59)
    assert body.results[-1].result == "reached"
    assert body.results[-1].reason == "forward is at 59 cm"
    assert body.results[-1].distance_m > 0.0


def test_a_rule_still_slows_a_distance(body):
    body.see(forward=0.4)
    driving(body, power=1.0)
    assert body.wheels[0] < 0.4
