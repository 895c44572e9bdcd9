"""Motors, ranges, odometry and attitude at rest are heard twice a second: a motion begins at once, and ends by them as ever."""

import pytest
from msgspec.structs import replace

from lbr.messages.drive import DriveCommand
from lbr.operations.drive.granting import to_be_checked
from lbr.operations.drive.state import Command
from tests.operations.drive.drive_bench import Bench, motors, ranges
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


@pytest.fixture
def ringed():
    bench = Bench()
    bench.around = replace(bench.around, rests=True)
    bench.sense()
    bench.ranges_speak = False
    return bench


@pytest.mark.parametrize(("age_s", "accepted"), [(0.31, True), (0.9, True), (1.19, True), (1.21, False)])
def test_ranges_at_rest_may_be_older_before_a_motion(ringed, age_s, accepted):
    rest(ringed, age_s)
    reply = ringed.drive(0.5)
    assert (reply.accepted, reply.code) == (accepted, "" if accepted else "stale_sensor")


@pytest.mark.parametrize(("rests", "speak", "moves"), [(False, True, True), (True, True, True), (True, False, False)])
def test_ranges_have_the_usual_time_to_report_once_the_base_is_to_move(ringed, rests, speak, moves):
    rest(ringed, 0.5)
    reply = ringed.drive(0.5)
    ringed.around = replace(ringed.around, rests=rests)
    ringed.ranges_speak = speak
    ringed.run(0.28, renewing(ringed, reply))
    assert ringed.wheels != STILL
    ringed.ranges_speak = speak and not rests
    ringed.run(0.06, renewing(ringed, reply))
    assert (ringed.wheels != STILL) is moves
    ringed.stop()
    ringed.now += 0.3
    ringed.sense()
    assert moves or ringed.drive(0.5).code == "stale_sensor"


def test_ranges_that_rested_in_the_midst_of_a_motion_are_believed_no_longer(ringed):
    reply = ringed.drive(0.5)
    ringed.ranges_speak = True
    ringed.run(0.1, renewing(ringed, reply))
    ringed.ranges_speak = False
    ringed.run(0.2, renewing(ringed, reply))
    assert ringed.wheels != STILL
    ringed.run(0.06, renewing(ringed, reply))
    assert ringed.wheels == STILL
    ringed.stop()
    ringed.now += 0.3
    ringed.sense()
    assert ringed.drive(0.5).code == "stale_sensor"


def test_an_obstacle_of_old_still_refuses_a_motion_and_a_new_one_does_at_once(ringed):
    ringed.around = replace(ranges(forward=1.0), rests=True)
    ringed.ranges_speak = True
    ringed.sense()
    rest(ringed, 0.9)
    ringed.around = ranges(forward=0.2)
    ringed.sense()
    assert ringed.drive(0.5).code == "obstacle"
    ringed.around = replace(ringed.around, rests=True)
    ringed.sense()
    ringed.ranges_speak = False
    rest(ringed, 0.9)
    assert ringed.drive(0.5).code == "obstacle"
    assert ringed.wheels == STILL


def test_an_offer_before_resting_ranges_is_confirmed_and_moves(ringed):
    rest(ringed, 0.4)
    offer = ringed.drive_from_afar(0.5, ttl_s=0.9)
    for _ in range(2):
        rest(ringed, 0.25)
    assert ringed.drive_from_afar(0.5, lease=offer.lease).accepted
    rest(ringed, 0.02)
    assert ringed.wheels != STILL


def test_users_checks_are_asked_before_a_motion_that_resting_ranges_allow(ringed):
    rest(ringed, 0.9)
    names = {"source": "console", "new_lease": "x", "new_goal": "y"}
    asked = Command(command=DriveCommand(power=0.5), received=ringed.now, **names)
    assert to_be_checked(ringed.state, asked, ringed.now)


def test_a_move_to_a_range_begins_by_a_reading_at_rest(ringed):
    ringed.around = replace(ranges(forward=1.0), rests=True)
    ringed.ranges_speak = True
    ringed.sense()
    ringed.ranges_speak = False
    rest(ringed, 0.9)
    command = {"power": 0.3, "range_cm": 60.0, "sensor": "forward"}
    reply = ringed.drive(**command)
    assert reply.accepted, reply.reason
    ringed.run(0.28, lambda: ringed.drive(**command, lease=reply.lease))
    assert (ringed.wheels != STILL, ringed.results) == (True, [])
    ringed.run(0.06, lambda: ringed.drive(**command, lease=reply.lease))
    assert [result.code for result in ringed.results] == ["stale_sensor"]
