"""What is old, repeated or held back moves nothing; what comes from afar proves first that it is new."""

from math import inf, nan

import pytest

from lbr.leases.lease import Stop
from lbr.messages.drive import CheckVerdict, DriveCommand
from lbr.operations.drive.granting import to_be_checked
from lbr.operations.drive.kernel import drive_state
from lbr.operations.drive.state import Command, MotorsSeen, RangesSeen
from tests.operations.drive.drive_bench import Bench, motors

STILL = (0.0, 0.0)


@pytest.fixture
def bench():
    return Bench()


def reason(bench):
    return drive_state(bench.state, bench.now).reason


def confirmed(bench, power=0.5, *, sender_s=nan, **more):
    """A page on another machine that drives: it asked, and quoted the lease it was given 50 ms later."""
    offer = bench.drive_from_afar(power, sender_s=sender_s, **more)
    bench.now += 0.05
    reply = bench.drive_from_afar(power, sender_s=sender_s + 0.05, lease=offer.lease, **more)
    assert reply.accepted, reply.reason
    return reply


# on this machine


def test_a_command_that_began_something_begins_nothing_again(bench):
    sent = bench.now
    assert bench.drive(0.5, ttl_s=0.1, sent=sent).accepted
    bench.run(0.12)
    assert bench.drive(0.5, ttl_s=0.1, sent=sent).code == "repeated"
    assert bench.wheels == STILL


def test_a_take_over_that_was_overtaken_by_a_newer_motion_takes_nothing(bench):
    bench.now += 0.1
    bench.drive(0.5)
    assert not bench.drive(0.5, source="phone", take_over=True, sent=bench.now - 0.05).accepted
    assert bench.state.lease.source == "console"


def test_a_repeated_renewal_does_not_prolong_a_motion(bench):
    reply = bench.drive(0.5)
    bench.now += 0.1
    sent = bench.now
    assert bench.drive(0.5, lease=reply.lease).accepted
    bench.run(0.18, lambda: bench.drive(0.5, lease=reply.lease, sent=sent))
    assert {each.code for each in bench.replies[-2:]} == {"repeated"}
    bench.run(0.14, lambda: bench.drive(0.5, lease=reply.lease, sent=sent))
    assert bench.wheels == STILL


def test_a_renewal_counts_from_when_it_was_sent(bench):
    reply = bench.drive(0.5)
    bench.now += 0.25
    assert bench.drive(0.5, lease=reply.lease, sent=bench.now - 0.2).accepted
    bench.run(0.12)
    assert bench.wheels == STILL


def test_an_older_speed_does_not_come_back_after_a_newer_one(bench):
    reply = bench.drive(0.8)
    sent = bench.now = bench.now + 0.05
    bench.now += 0.05
    assert bench.drive(0.2, lease=reply.lease).accepted
    assert not bench.drive(0.8, lease=reply.lease, sent=sent).accepted
    assert bench.state.lease.motion.command.power == 0.2


@pytest.mark.parametrize("newest", [0.0, 0.2])
def test_a_motion_that_a_renewal_has_overtaken_does_not_come_back(bench, newest):
    reply = bench.drive(0.5)
    bench.now += 0.05
    assert bench.drive(newest, lease=reply.lease).accepted
    sent = bench.now = bench.now + 0.05
    bench.now += 0.05
    assert bench.drive(newest, lease=reply.lease).accepted
    overtaken = bench.drive(0.8, lease=reply.lease, sent=sent)
    assert overtaken.code == "repeated"
    assert bench.state.lease.motion.command.power == newest


@pytest.mark.parametrize(
    ("age_s", "checked", "accepted"), [(0.31, False, False), (0.49, True, True), (0.51, True, False)]
)
def test_a_command_may_be_older_by_twice_the_time_that_the_users_checks_took(bench, age_s, checked, accepted):
    checks = {"cliff": CheckVerdict(accepted=True)} if checked else {}
    assert bench.drive(0.5, sent=bench.now - age_s, checks=checks).accepted is accepted


def test_standing_still_is_never_too_late(bench):
    reply = bench.drive(0.5)
    bench.run(0.2)
    assert bench.drive(0.0, lease=reply.lease, sent=bench.now - 5.0).accepted
    assert bench.wheels == STILL
    assert bench.drive(0.0, sent=bench.now - 5.0).accepted


def test_what_was_sent_while_the_emergency_stop_was_latched_does_not_move_it_after_the_reset(bench):
    bench.estop(True)
    bench.now += 1.0
    sent = bench.now
    bench.now += 0.05
    bench.estop(False)
    assert bench.drive(0.5, sent=sent).code == "stopped"


def test_a_stream_that_never_quotes_its_lease_stops_and_stays_so(bench):
    bench.run(0.25, lambda: bench.drive(0.5))
    reply = bench.replies[-1]
    assert (reply.code, reply.holder, "quote" in reply.reason) == ("held", "console", True)
    assert bench.wheels != STILL
    bench.run(2.0, lambda: bench.drive(0.5))
    assert (bench.replies[-1].code, "quoting" in bench.replies[-1].reason) == ("rest_first", True)
    assert bench.wheels == STILL
    bench.run(0.3)
    assert bench.drive(0.5).accepted


def test_a_drive_that_is_held_up_does_not_take_its_own_delay_for_a_pause(bench):
    bench.estop(True)
    bench.run(0.1)
    assert bench.drive(0.5).code == "estop"
    waiting = [bench.now + 0.1 * number for number in range(1, 5)]
    bench.run(0.45)
    bench.estop(False)
    assert not any(bench.drive(0.5, sent=sent).accepted for sent in waiting)
    bench.run(0.1)
    assert bench.drive(0.5).code == "rest_first"
    bench.run(0.3)
    assert bench.drive(0.5).accepted


def test_a_stream_does_not_go_on_by_taking_over_from_itself(bench):
    bench.run(1.0, lambda: bench.drive(0.5, take_over=True))
    assert (bench.replies[-1].code, "quoting" in bench.replies[-1].reason) == ("rest_first", True)
    assert bench.wheels == STILL


def test_who_quoted_a_lease_and_lets_go_may_ask_anew_as_often_as_it_likes(bench):
    reply = bench.drive(0.5)
    bench.run(0.2, lambda: bench.drive(0.5, lease=reply.lease))
    bench.replies.clear()
    bench.run(0.4, lambda: bench.drive(0.5))
    assert any(each.accepted for each in bench.replies)


def test_a_flood_of_senders_through_the_emergency_stop_lets_none_of_them_through(bench):
    bench.estop(True)
    for count in range(200):
        bench.drive(0.5, source=f"stuck {count}")
    bench.estop(False)
    bench.now += 0.1
    assert len(bench.state.leases.persistent) <= 65
    assert not any(bench.drive(0.5, source=f"stuck {count}").accepted for count in range(200))


# from afar


def test_what_was_not_confirmed_in_time_is_dead(bench):
    offer = bench.drive_from_afar(0.5, interval_s=2.0)
    bench.run(0.32)
    assert reason(bench) == "no sender drives"
    assert bench.drive_from_afar(0.5, lease=offer.lease).reason == "lease is dead: not confirmed within 0.3 s"
    assert [(each.goal, each.result) for each in bench.results] == [(offer.goal, "lapsed")]


def test_a_put_from_afar_is_told_to_ask_first(bench):
    assert "begins with a query" in bench.drive_from_afar(0.5, answerable=False).reason
    assert bench.drive_from_afar(0.0, answerable=False).accepted


def test_a_confirmation_may_be_a_put_and_may_change_the_motion(bench):
    offer = bench.drive_from_afar(0.5)
    bench.now += 0.05
    assert bench.drive_from_afar(0.2, 90.0, lease=offer.lease, answerable=False).accepted
    assert bench.state.lease.motion.command.angle_deg == 90.0


def test_a_bounded_move_starts_its_clock_at_the_confirmation(bench):
    offer = bench.drive_from_afar(0.5, interval_s=0.2)
    bench.now += 0.25
    bench.sense()
    bench.drive_from_afar(0.5, interval_s=0.2, lease=offer.lease)
    bench.run(0.18)
    assert bench.results == []
    bench.run(0.04)
    assert [(each.goal, each.result) for each in bench.results] == [(offer.goal, "interval")]


def test_an_offer_holds_nobody_up_and_ends_nobodys_motion(bench):
    mine = bench.drive(0.5)
    bench.now += 0.01
    assert bench.drive_from_afar(0.5).reason == "held by console; stop it first"
    offer = bench.drive_from_afar(0.5, take_over=True)
    assert offer.accepted
    bench.now += 0.01
    assert bench.drive(0.5, lease=mine.lease).accepted
    bench.now += 0.01
    assert bench.drive_from_afar(0.5, lease=offer.lease).accepted
    assert bench.drive(0.5, lease=mine.lease).reason == "lease is dead: taken over by page"


def test_somebody_nearer_may_begin_while_an_offer_waits(bench):
    offer = bench.drive_from_afar(0.5)
    bench.now += 0.01
    assert bench.drive(0.5).accepted
    bench.now += 0.01
    assert bench.drive_from_afar(0.5, lease=offer.lease).reason == "held by console; stop it first"


@pytest.mark.parametrize(
    ("end", "why"),
    [
        (lambda b: b.stop(), "stopped by phone"),
        (lambda b: (b.estop(True), b.estop(False)), "emergency stop: button"),
        (lambda b: (b.lose_motors(), b.sense()), "motors is gone"),
        (lambda b: b.drive_from_afar(0.3), "another command came"),
    ],
    ids=["stop", "e-stop", "motors", "another"],
)
def test_an_offer_ends_with_whatever_ends_a_motion(bench, end, why):
    offer = bench.drive_from_afar(0.5)
    end(bench)
    bench.now += 0.01
    assert bench.drive_from_afar(0.5, lease=offer.lease).reason == f"lease is dead: {why}"
    assert bench.wheels == STILL


def test_offers_are_few(bench):
    leases = [bench.drive_from_afar(0.5, source=f"page {count}").lease for count in range(20)]
    assert len(bench.state.leases.offers) == 8
    bench.now += 0.01
    assert not bench.drive_from_afar(0.5, source="page 0", lease=leases[0]).accepted
    assert bench.drive_from_afar(0.5, source="page 19", lease=leases[19]).accepted


def test_a_confirmation_is_checked_only_if_it_asks_for_something_else(bench):
    offer = bench.drive_from_afar(0.5)

    def asks(power):
        command = DriveCommand(power=power, lease=offer.lease)
        names = {"source": "page", "new_lease": "x", "new_goal": "y"}
        return to_be_checked(bench.state, Command(command=command, received=bench.now, remote=True, **names), bench.now)

    assert not asks(0.5)
    assert asks(0.6)


@pytest.mark.parametrize("clock_s", [0.0, 3.0, 1e9, -5.0])
def test_renewals_that_were_held_back_are_dated_by_the_quickest(bench, clock_s):
    began = bench.now
    reply = confirmed(bench, sender_s=clock_s)
    bench.now += 0.1
    assert bench.drive_from_afar(0.5, lease=reply.lease, sender_s=clock_s + bench.now - began).accepted
    for held_back_s in (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4):
        bench.now += 0.1
        sender_s = clock_s + bench.now - began - held_back_s
        last = bench.drive_from_afar(0.5, lease=reply.lease, sender_s=sender_s)
        bench.sense()
    assert not last.accepted, "a stream that falls behind is not followed"


def test_from_afar_only_the_sender_that_was_given_a_lease_may_quote_it(bench):
    reply = confirmed(bench)
    bench.now += 0.01
    stolen = bench.drive_from_afar(0.9, source="thief", lease=reply.lease)
    assert (stolen.code, "page" in stolen.reason) == ("foreign_lease", True)
    assert bench.drive_from_afar(0.0, source="thief", lease=reply.lease).accepted, "anybody may have it stand still"


def test_another_who_quotes_a_lease_does_not_make_its_sender_look_fresher(bench):
    began = bench.now
    reply = confirmed(bench, sender_s=0.0)
    bench.now += 0.1
    bench.drive(0.4, lease=reply.lease, source="thief")
    bench.now += 0.1
    bench.drive_from_afar(0.0, lease=reply.lease, source="other thief", sender_s=1e6)
    bench.sense()
    bench.now += 0.15
    bench.sense()
    late = bench.drive_from_afar(0.5, lease=reply.lease, sender_s=bench.now - began - 0.31)
    assert (late.code, "0.3 s" in late.reason) == ("late", True)


@pytest.mark.parametrize("sender_s", [nan, inf, -inf, 1e300, -1e300, 0.0])
def test_a_clock_that_makes_no_sense_moves_nothing_late(bench, sender_s):
    offer = bench.drive_from_afar(0.5, sender_s=sender_s)
    bench.now += 0.31
    bench.sense()
    assert not bench.drive_from_afar(0.5, sender_s=sender_s, lease=offer.lease).accepted


# clocks and order


@pytest.mark.parametrize("step_s", [-0.001, -3600.0, nan, inf, 3600.0])
def test_a_step_of_the_clock_stops_it_and_moves_nothing_afterwards(bench, step_s):
    reply = bench.drive(0.5)
    offer = bench.drive_from_afar(0.5, take_over=True)
    bench.run(0.2, lambda: bench.drive(0.5, lease=reply.lease))
    before = bench.now
    bench.now += step_s
    bench.event_tick()
    assert bench.wheels == STILL
    bench.drive(0.5, lease=reply.lease)
    bench.drive(0.5, lease=offer.lease)
    bench.now = before + 0.02
    for _ in range(3):
        bench.drive(0.5, lease=reply.lease)
        bench.event_tick()
        assert bench.wheels == STILL
    bench.run(0.3)
    assert bench.drive(0.5).accepted
    bench.run(0.1)
    assert bench.wheels != STILL


def test_after_the_clock_went_back_motors_are_believed_anew_and_nothing_else_of_before(bench):
    bench.look(heading_deg=0.0)
    bench.count()
    bench.lose_motors()
    bench.now -= 50.0
    bench.event_tick()
    bench.now += 0.5
    bench.sense()
    assert bench.drive(0.5).accepted
    bench.stop()
    bench.now += 0.1
    assert bench.turn(90.0).code == bench.drive(0.5, distance_cm=50.0).code == "stale_sensor"


def test_what_the_motors_said_before_they_were_lost_brings_nothing_back(bench):
    said = bench.now
    bench.now += 0.05
    bench.lose_motors()
    bench.event(MotorsSeen(motors=motors(), arrived=said))
    assert bench.drive(0.5).reason == "motors is gone"


@pytest.mark.parametrize("arrived", [nan, 1e9])
def test_a_reading_with_an_impossible_date_is_no_fresher_for_it(bench, arrived):
    bench.event(MotorsSeen(motors=motors(), arrived=arrived))
    bench.event(RangesSeen(ranges=bench.around, arrived=arrived))
    bench.now += 0.31
    assert "silent" in bench.drive(0.5).reason
    bench.ranges_speak = False
    bench.sense()
    assert not bench.drive(0.5).accepted


def test_an_overtaken_reading_does_not_replace_a_newer_one(bench):
    before = bench.now
    bench.now += 0.1
    bench.see(forward=0.2)
    bench.event(RangesSeen(ranges=Bench().around, arrived=before))
    assert bench.state.views["forward"].raw_m == 0.2


def test_a_stop_without_a_date_counts_as_now(bench):
    sent = bench.now
    bench.now += 0.1
    bench.event(Stop(source="phone", received=nan))
    assert not bench.drive(0.5, sent=sent).accepted
    bench.now += 0.01
    assert bench.drive(0.5).accepted
