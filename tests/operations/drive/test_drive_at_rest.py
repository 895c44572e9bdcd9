"""Motors, odometry and attitude at rest are heard twice a second: a motion begins at once, and ends by them as ever."""

import pytest
from msgspec.structs import replace

from tests.operations.drive.drive_bench import Bench, motors
from tests.operations.drive.drive_body import Body

STILL = (0.0, 0.0)


@pytest.fixture
def bench():
    bench = Bench()
    bench.motors = replace(motors(), rests=True)
    bench.sense()
    bench.motors_speak = False
    return bench


def rest(bench, seconds):
    bench.now += seconds
    bench.sense()  # ranges alone
    bench.event_tick()


def renewing(bench, reply):
    return lambda: bench.drive(0.5, lease=reply.lease)


@pytest.mark.parametrize(("age_s", "accepted"), [(0.29, True), (0.9, True), (1.19, True), (1.21, False)])
def test_motors_at_rest_may_be_older_before_a_motion(bench, age_s, accepted):
    rest(bench, age_s)
    reply = bench.drive(0.5)
    assert reply.accepted is accepted
    if not accepted:
        assert (reply.code, "1.2 s" in reply.reason) == ("unreachable", True)


@pytest.mark.parametrize(("motors_speak", "moves"), [(True, True), (False, False)])
def test_motors_have_the_usual_time_to_be_heard_once_they_are_to_move(bench, motors_speak, moves):
    rest(bench, 0.9)
    reply = bench.drive(0.5)
    bench.motors = motors()
    bench.motors_speak = motors_speak
    bench.run(0.28, renewing(bench, reply))
    assert bench.wheels != STILL
    bench.run(0.06, renewing(bench, reply))
    assert (bench.wheels != STILL) is moves
    assert moves or "silent for more than 0.3 s" in bench.texts[-1]


@pytest.mark.parametrize(("speaks", "ends"), [(True, ""), (False, "the odometry is older than 0.3 s")])
def test_a_distance_begins_by_odometry_at_rest_and_ends_without_it_as_ever(speaks, ends):
    body = Body()
    body.now += 0.01
    body.count(distance_m=0.0, speed_mps=0.0, rests=True)
    body.now += 0.9
    body.sense()
    reply = body.drive(0.4, distance_cm=100.0)
    assert reply.accepted, reply.reason
    body.odometry_speaks = speaks
    for tick in range(18):
        if tick % 5 == 0:
            body.sense()
            body.drive(0.4, distance_cm=100.0, lease=reply.lease)
        body.step()
    assert (body.wheels == STILL) is bool(ends)
    assert [ends in result.reason for result in body.results] == [True] * bool(ends)


def test_a_distance_is_over_with_the_odometry_that_comes_to_rest_as_the_next_comes_late():
    body = Body()
    command = {"power": 0.4, "distance_cm": 50.0}
    reply = body.drive(**command)

    def step(ticks):
        for _ in range(ticks):
            body.sense()
            body.drive(**command, lease=reply.lease)
            body.step()

    step(5)
    while body.wheels != STILL:
        step(1)
    body.odometry_speaks = False
    step(10)
    body.count(distance_m=body.way_m, speed_mps=0.0, rests=True)
    step(20)
    assert [result.result for result in body.results] == ["reached"]


def test_a_short_distance_is_not_over_by_the_rest_before_it():
    body = Body()
    body.now += 0.01
    body.count(distance_m=0.0, speed_mps=0.0, rests=True)
    reply = body.drive(0.4, distance_cm=2.0)
    assert reply.accepted, reply.reason
    body.now += 0.01
    body.count(distance_m=0.0, speed_mps=0.0, rests=True)
    body.step()
    assert body.results == []


def resting_body(age_s):
    body = Body()
    body.now += 0.01
    body.look(turned_deg=body.turned_deg, heading_deg=0.0, rests=True)
    body.now += age_s
    body.sense()
    return body


@pytest.mark.parametrize(("age_s", "accepted"), [(0.21, True), (1.19, True), (1.21, False)])
def test_an_attitude_at_rest_may_be_older_before_a_turn(age_s, accepted):
    reply = resting_body(age_s).turn(90.0)
    assert reply.accepted is accepted
    assert accepted or "1.2 s" in reply.reason


@pytest.mark.parametrize(("speaks", "ends"), [(True, ""), (False, "the attitude is older than 0.2 s")])
def test_a_turn_begins_by_an_attitude_at_rest_and_ends_without_a_newer_one_as_ever(speaks, ends):
    body = resting_body(0.9)
    reply = body.turn(90.0)
    assert reply.accepted, reply.reason
    body.attitude_speaks = speaks
    for tick in range(11):
        if tick % 5 == 0:
            body.sense()
            body.turn(90.0, lease=reply.lease)
        body.step()
    assert (body.wheels == STILL) is bool(ends)
    assert [ends in result.reason for result in body.results] == [True] * bool(ends)


def test_the_first_rate_of_a_turn_is_not_spread_over_the_rest_before_it():
    body = resting_body(0.5)
    body.look(turned_deg=body.turned_deg + 8.0, heading_deg=8.0)
    assert body.state.heading.rate_dps == pytest.approx(50.0)
