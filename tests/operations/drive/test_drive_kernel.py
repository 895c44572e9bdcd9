"""The kernel's decisions, one sentence each."""

from math import inf, nan

import pytest
from msgspec.structs import replace

from lbr.messages.drive import CheckVerdict
from lbr.operations.drive.kernel import drive_state
from lbr.operations.drive.rules import FREE, Limit
from lbr.operations.drive.wheels import tell
from tests.operations.drive.drive_bench import Bench, motors, ranges

STILL = (0.0, 0.0)


@pytest.fixture
def bench():
    return Bench()


def renewing(bench, reply, power=0.5, angle_deg=0.0, **more):
    return lambda: bench.drive(power, angle_deg, lease=reply.lease, **more)


def moving(bench, power=0.5, angle_deg=0.0, **more):
    reply = bench.drive(power, angle_deg, **more)
    assert reply.accepted, reply.reason
    bench.run(0.4, renewing(bench, reply, power, angle_deg, **more))
    assert bench.wheels != STILL
    return reply


# accepting


def test_the_checks_are_in_the_order_of_the_design(bench):
    """Everything objects to the first command, and one check less to each that follows."""
    bench.see(forward=0.1)
    bench.estop(engaged=True)
    wrong = {"power": nan, "lease": "none", "interval_s": 1000.0, "checks": {"mine": None}}
    codes = [bench.drive(**wrong).code]
    for change, mend in (
        ({"power": 0.5}, lambda: None),
        ({"lease": ""}, lambda: None),
        ({}, lambda: (bench.estop(engaged=False), bench.run(0.5))),
        ({"interval_s": 1.0}, lambda: None),
        ({}, lambda: (bench.see(), bench.run(0.5))),
        ({"checks": {}}, lambda: None),
    ):
        mend()
        wrong |= change
        codes.append(bench.drive(**wrong).code)
    assert codes == ["bad_value", "dead_lease", "estop", "limit", "obstacle", "check", ""]


def test_a_command_may_ask_for_a_longer_life(bench):
    assert bench.drive(0.5, ttl_s=0.8).ttl_s == 0.8
    bench.run(0.7)
    assert bench.wheels != STILL


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"power": nan}, "power nan is outside 0 to 1"),
        ({"power": inf}, "power inf is outside 0 to 1"),
        ({"power": 1.01}, "power 1.01 is outside 0 to 1"),
        ({"power": -0.1}, "power -0.1 is outside"),
        ({"angle_deg": nan}, "angle_deg nan is outside"),
        ({"angle_deg": 361.0}, "angle_deg 361 is outside -360 to 360"),
        ({"range_cm": nan}, "range_cm nan"),
        ({"interval_s": -1.0}, "interval_s -1"),
        ({"ttl_s": 1.5}, "ttl_s 1.5"),
        ({"ttl_s": 0.0}, "ttl_s 0 lets a lease"),
        ({"sensor": "front"}, "sensor 'front' is not one of forward, back"),
    ],
)
def test_nonsense_is_refused_and_named(bench, fields, complaint):
    reply = bench.drive(**{"power": 0.5, **fields})
    assert not reply.accepted
    assert complaint in reply.reason
    bench.run(0.2)
    assert bench.wheels == STILL


def test_taking_over_ends_the_other_lease_and_begins_at_zero(bench):
    first = moving(bench)
    second = bench.drive(0.5, source="phone", take_over=True)
    assert second.accepted
    assert bench.setpoints[-2].left == 0.0
    assert bench.setpoints[-1].left < 0.1
    assert bench.drive(0.5, lease=first.lease).reason == "lease is dead: taken over by phone"


def test_motors_that_are_not_armed_are_named_with_their_reason(bench, wording):
    bench.motors = motors(armed=False, reason="no zero setpoint yet")
    bench.sense()
    wording(bench.drive(0.5))


def test_a_motion_that_ends_for_want_of_setpoints_has_their_code(bench):
    moving(bench)
    bench.motors = motors(armed=False, reason="no setpoint within 0.1 s", code="no_setpoint")
    bench.sense()
    assert (bench.state.lease, bench.state.leases.reason.code) == (None, "no_setpoint")


def test_more_than_the_highest_power_is_limited_and_said():
    bench = Bench(max_power=0.8)
    assert bench.drive(0.8).reason == ""
    bench.stop()
    bench.now += 0.01
    reply = bench.drive(1.0)
    assert (reply.code, reply.reason) == ("limit", "limited to 0.8")
    bench.run(0.8, renewing(bench, bench.replies[-1], 1.0))
    assert bench.wheels == pytest.approx((0.8, 0.8))


def test_motion_towards_an_obstacle_does_not_start(bench):
    bench.see(forward=0.21)
    assert bench.drive(0.5).reason == "forward 0.21 m is inside 0.25 m"
    assert bench.drive(0.5, 180).accepted


def test_the_asker_is_told_how_far_a_rule_slows_it(bench):
    bench.see(forward=0.42)
    reply = bench.drive(0.5)
    assert (reply.code, reply.reason) == ("obstacle", "slowed to 0.39 by forward 0.42 m")


@pytest.mark.parametrize(
    ("verdict", "reason"),
    [
        (None, "check cliff did not answer"),
        (CheckVerdict(accepted=False, reason="a cliff"), "check cliff: a cliff"),
        (CheckVerdict(accepted=False), "check cliff: refused without a reason"),
    ],
)
def test_a_users_check_may_refuse(bench, verdict, reason):
    assert bench.drive(0.5, checks={"cliff": verdict}).reason == reason
    assert bench.drive(0.5, checks={"cliff": CheckVerdict(accepted=True)}).accepted


# leases


def test_a_refused_change_changes_nothing(bench):
    reply = moving(bench)
    bench.see(back=0.1)
    assert not bench.drive(0.5, 180, lease=reply.lease).accepted
    bench.run(0.1)
    assert bench.wheels == pytest.approx((0.5, 0.5))


def test_power_zero_under_the_lease_keeps_it_alive_at_neutral(bench):
    reply = moving(bench)
    bench.drive(0.0, lease=reply.lease)
    assert bench.wheels == STILL
    bench.run(60.0, renewing(bench, reply, 0.0), sense_each=10)
    assert bench.drive(0.5, lease=reply.lease).accepted


def test_dead_leases_are_remembered_with_their_reason(bench):
    leases = []
    for _ in range(40):
        bench.now += 0.001
        leases.append(bench.drive(0.5).lease)
        bench.stop(reason="enough")
    for lease in leases[-31:]:
        bench.drive(0.5, lease=lease)
    assert bench.drive(0.5, lease=leases[-2]).reason == "lease is dead: stopped by phone: enough"
    assert len(bench.state.leases.revoked) == 32


def test_motion_ends_when_nobody_changes_it_for_too_long():
    bench = Bench(max_run_s=2.0)
    reply = bench.drive(0.5)
    bench.run(2.1, renewing(bench, reply))
    assert bench.wheels == STILL
    assert bench.drive(0.5, lease=reply.lease).reason == "lease is dead: it ran for 2 s unattended"


def test_a_changed_command_may_run_anew():
    bench = Bench(max_run_s=2.0)
    reply = bench.drive(0.5)
    bench.run(1.5, renewing(bench, reply))
    bench.drive(0.4, lease=reply.lease)
    bench.run(1.5, renewing(bench, reply, 0.4))
    assert bench.wheels == pytest.approx((0.4, 0.4))


# faults


@pytest.mark.parametrize(
    ("fault", "why"),
    [
        (lambda b: b.lose_motors(), "motors is gone"),
        (lambda b: (setattr(b, "motors", motors(armed=False, reason="tripped")), b.sense()), "not armed: tripped"),
        (lambda b: b.estop(True), "emergency stop: button"),
    ],
    ids=["lost", "tripped", "e-stop"],
)
def test_a_fault_stops_at_once_and_for_ever(bench, fault, why):
    reply = moving(bench, interval_s=10.0)
    fault(bench)
    assert (bench.setpoints[-1].left, bench.setpoints[-1].right, bench.setpoints[-1].lease) == (0.0, 0.0, "")
    assert [result.result for result in bench.results] == ["fault"]
    assert any(why in text for text in bench.texts)
    bench.estop(False)
    bench.motors = motors()
    bench.sense()
    bench.run(1.0, renewing(bench, reply, interval_s=10.0))
    assert bench.wheels == STILL
    assert why in bench.replies[-1].reason


# bounded moves


def approach(bench, watched, metres, reply, **command):
    for value in metres:
        bench.now += 0.1
        bench.around = ranges(**{watched: value})
        bench.sense()
        bench.drive(lease=reply.lease, **command)


def test_a_move_ends_when_the_distance_has_shrunk_to_the_target(bench):
    bench.see(forward=0.6)
    command = {"power": 0.2, "range_cm": 40.0, "sensor": "forward"}
    reply = bench.drive(**command)
    assert reply.goal == "goal1"
    approach(bench, "forward", (0.55, 0.48, 0.41), reply, **command)
    assert bench.results == []
    approach(bench, "forward", (0.40,), reply, **command)
    (result,) = bench.results
    assert (result.goal, result.result, result.range_cm) == ("goal1", "reached", 40.0)
    assert result.elapsed_s == pytest.approx(0.4)
    assert bench.setpoints[-1].left == 0.0
    assert "forward is at 40 cm" in bench.replies[-1].reason


def test_a_move_ends_when_the_distance_has_grown_to_the_target(bench):
    bench.see(forward=0.6)
    command = {"power": 0.2, "angle_deg": 180.0, "range_cm": 80.0, "sensor": "forward"}
    reply = bench.drive(**command)
    approach(bench, "forward", (0.65, 0.75), reply, **command)
    assert bench.results == []
    approach(bench, "forward", (0.83,), reply, **command)
    assert bench.results[0].result == "reached"


@pytest.mark.parametrize(
    ("around", "command", "reason"),
    [
        ({"forward": 0.35}, {"range_cm": 40.0}, "forward is at 35 cm already, range_cm is 40"),
        ({"forward": 0.40}, {"range_cm": 40.0}, "forward is at 40 cm already"),
        ({"forward": 0.90}, {"range_cm": 80.0, "angle_deg": 180.0}, "forward is at 90 cm already"),
        ({}, {"range_cm": 80.0, "angle_deg": 180.0}, "forward is beyond its reach already"),
        ({"forward": 2.0}, {"range_cm": 16.0}, "range_cm 16 is outside 17 to 768"),
        ({"forward": 2.0}, {"range_cm": 768.5}, "range_cm 768.5 is outside 17 to 768"),
        ({"forward": 2.0}, {"range_cm": 20.0}, "range_cm 20 is out of reach: the forward rule stops at 25 cm"),
        ({"bottom": "missing"}, {"range_cm": 40.0, "sensor": "bottom"}, "sensor bottom has no reading to watch"),
        ({}, {"interval_s": 31.0}, "interval_s 31 is longer than max_run_s 30"),
    ],
)
def test_bounds_that_make_no_sense_are_refused_with_the_present_value(bench, around, command, reason):
    bench.see(**around)
    reply = bench.drive(**{"power": 0.2, **command})
    assert not reply.accepted
    assert reason in reply.reason


def test_a_time_may_be_as_long_as_the_longest_run(bench):
    assert bench.drive(0.2, interval_s=30.0).accepted


def test_a_move_ends_after_its_interval_and_renewals_do_not_prolong_it(bench):
    reply = bench.drive(0.5, interval_s=1.0)
    bench.run(0.98, renewing(bench, reply, interval_s=1.0))
    assert bench.wheels != STILL
    bench.run(0.04, renewing(bench, reply, interval_s=1.0))
    assert bench.wheels == STILL
    assert [(r.result, r.elapsed_s) for r in bench.results] == [("interval", pytest.approx(1.0, abs=0.03))]


def test_a_move_whose_sensor_is_lost_is_a_fault(bench):
    bench.see(bottom=2.0)
    command = {"power": 0.2, "range_cm": 40.0, "sensor": "bottom"}
    reply = bench.drive(**command)
    bench.around = ranges(bottom="missing")
    bench.run(0.4, lambda: bench.drive(lease=reply.lease, **command))
    assert [(r.result, r.reason) for r in bench.results] == [("fault", "sensor bottom was lost")]


@pytest.mark.parametrize(
    ("end", "result"),
    [
        (lambda b, reply: b.stop(), "stopped"),
        (lambda b, reply: b.run(0.4), "lapsed"),
        (lambda b, reply: b.drive(0.3, lease=reply.lease), "superseded"),
        (lambda b, reply: b.drive(0.0, lease=reply.lease), "superseded"),
        (lambda b, reply: b.drive(0.3, source="phone", take_over=True), "superseded"),
        (lambda b, reply: b.estop(True), "fault"),
    ],
    ids=["stop", "silence", "change", "neutral", "take-over", "e-stop"],
)
def test_a_move_that_is_ended_says_so_once_and_never_acts_later(bench, end, result):
    reply = bench.drive(0.5, interval_s=1.0)
    bench.run(0.1)
    end(bench, reply)
    assert [r.result for r in bench.results] == [result]
    bench.estop(False)
    bench.run(0.5)
    later = bench.drive(0.2, source="third", take_over=True)
    bench.run(2.0, renewing(bench, later, 0.2))
    assert bench.wheels == pytest.approx((0.2, 0.2)), "the old interval must not stop what came after it"
    assert len(bench.results) == 1


# wheels


def test_a_change_of_sense_goes_through_zero(bench):
    reply = moving(bench)
    bench.now += 0.02
    bench.drive(0.5, 180, lease=reply.lease)
    assert bench.wheels == STILL
    bench.run(0.02)
    assert bench.wheels == pytest.approx((-0.04, -0.04))


def test_wheels_grow_by_the_time_of_a_late_round_up_to_a_limit_but_from_rest_by_that_of_one_in_time(bench):
    bench.event_tick()
    seen = []
    for late_s in (0.06, 0.06, 0.12):
        bench.now += late_s
        bench.event_tick() if seen else bench.drive(1.0)
        seen.append(bench.wheels[0])
    assert seen == pytest.approx([0.04, 0.16, 0.36])


def test_an_arc_keeps_its_shape_while_it_grows_and_while_a_rule_slows_it(bench):
    bench.noise_m = 0.001
    bench.see(forward=0.6)
    reply = bench.drive(1.0, 20)
    ratio = 0.46677
    for _ in range(10):
        bench.run(0.1, renewing(bench, reply, 1.0, 20))
        left, right = bench.wheels
        assert right / left == pytest.approx(ratio, abs=1e-3)
    assert 0.3 < left < 0.99


def test_what_the_wheels_do_between_two_commands_is_ruled_too(bench):
    reply = moving(bench, 0.5, 45)
    assert bench.wheels == pytest.approx((0.5, 0.0))
    bench.see(forward=0.2)
    assert bench.drive(0.5, 90, lease=reply.lease).accepted
    seen = []
    for _ in range(10):
        bench.run(0.02, renewing(bench, reply, 0.5, 90), sense_each=1)
        seen.append(sum(bench.wheels))
    assert max(seen) <= 0.01, "no way ahead on the way to the spin"
    assert bench.wheels[0] > 0.1


# rules while moving


def test_a_rule_slows_and_stops_and_lets_go_again(bench):
    reply = moving(bench)
    seen = {}
    for metres in (0.6, 0.4, 0.3, 0.24, 0.27, 0.5, 0.9):
        bench.see(forward=metres)
        bench.run(0.2, renewing(bench, reply), sense_each=2)
        seen[metres] = bench.wheels[0]
    assert seen[0.6] == pytest.approx(0.5)
    assert 0.5 > seen[0.4] > seen[0.3] > seen[0.24] == 0.0
    assert seen[0.27] == 0.0, "a stop is held until there is a margin"
    assert seen[0.5] > 0.3


def test_the_state_names_the_rule_and_the_reason(bench):
    reply = moving(bench)
    bench.see(forward=0.3)
    bench.run(0.04, renewing(bench, reply), sense_each=1)
    assert drive_state(bench.state, bench.now).limited_by == "forward 0.30 m"
    bench.see(forward=0.2)
    bench.run(0.04, renewing(bench, reply), sense_each=1)
    state = drive_state(bench.state, bench.now)
    assert state.reason == "stopped by forward 0.20 m is inside 0.30 m"
    assert (state.moving, state.holder, state.limited_by) == (False, "console", "forward 0.20 m")
    bench.stop()
    assert drive_state(bench.state, bench.now).limited_by == ""


def test_a_rule_on_the_edge_does_not_flood_the_events(bench):
    reply = moving(bench)
    for step in range(50):
        bench.see(forward=0.52 if step % 2 else 0.47)
        bench.run(0.1, renewing(bench, reply), sense_each=2)
    assert 1 <= len([event for event in bench.events if event.kind == "rule"]) <= 10


def test_what_rules_do_is_told_when_it_changes_once_a_second_but_a_first_stop_at_once(bench, wording):
    slow = Limit(scale=0.5, direction="forward", text="forward 0.40 m")
    stop, aside = (Limit(scale=0.0, direction=side, detail=f"{side} 0.20 m") for side in ("forward", "left"))
    state, told = bench.state, []
    for at, limited in (
        (0.0, slow), (0.5, slow), (0.75, stop), (1.5, aside), (1.75, aside), (2.5, slow), (2.75, slow), (2.8, stop),
        (3.75, FREE), (3.8, FREE),
    ):  # fmt: skip
        state, events = tell(replace(state, limited=limited), at)
        told += [(at, event.level, event.code) for event in events]
        wording(*(event.text for event in events))
    warning = ("warning", "obstacle")
    assert told == [
        (0.0, "info", "obstacle"), (0.75, *warning), (1.75, *warning), (2.75, "info", "obstacle"), (2.8, *warning),
        (3.8, "info", ""),
    ]  # fmt: skip


@pytest.mark.parametrize(("how", "level"), [("stopped", "info"), ("lapsed", "warning"), ("fault", "warning")])
def test_an_end_that_nobody_wanted_is_told_as_a_warning(bench, how, level):
    moving(bench)
    if how == "stopped":
        bench.stop()
    elif how == "fault":
        bench.lose_motors()
    else:
        bench.run(1.0)
    assert [event.level for event in bench.events if event.kind == how] == [level]


def test_why_it_stands_is_in_its_state_and_while_it_drives_there_is_nothing_to_say(bench):
    state = drive_state(bench.state, bench.now)
    assert (state.power, state.angle_deg, state.stopped_s, state.halted_s) == (0.0, 0.0, None, None)
    bench.estop(engaged=True)
    bench.stop()
    bench.lose_motors()
    state = drive_state(bench.state, bench.now)
    assert (state.reason, state.code, state.estop) == ("emergency stop: button", "estop", True)
    assert (state.stopped_s, state.halted_s, state.halted_by) == (bench.now, bench.now, "phone")
    bench.estop(engaged=False)
    assert drive_state(bench.state, bench.now).code == "unreachable"
    bench.run(0.1)
    assert bench.drive(0.3).accepted
    state = drive_state(bench.state, bench.now)
    assert (state.reason, state.code, state.estop) == ("", "", False)


def test_a_frozen_range_stops_motion_towards_it(bench):
    bench.see(forward=2.0)
    reply = bench.drive(0.5)
    bench.run(1.5, renewing(bench, reply))
    assert bench.wheels == STILL
    assert "frozen at 2.00 m" in bench.texts[-1]


def test_a_motion_that_a_rule_holds_still_for_a_second_is_over_and_does_not_resume(bench):
    reply = moving(bench)
    bench.see(forward=0.2)
    bench.run(0.9, renewing(bench, reply), sense_each=2)
    bench.now += 0.01
    renewed = bench.drive(0.5, lease=reply.lease)
    assert (renewed.accepted, renewed.code) == (True, "obstacle"), "it may go on until the second is over"
    assert renewed.reason == "stopped by forward 0.20 m is inside 0.25 m"
    bench.run(0.3, renewing(bench, reply), sense_each=2)
    bench.see(forward=3.0)
    bench.run(0.5, renewing(bench, reply), sense_each=2)
    assert bench.wheels == (0.0, 0.0)
    assert "held still for 1 s: forward 0.20 m" in bench.drive(0.5, lease=reply.lease).reason


def test_a_short_hindrance_does_not_end_a_motion(bench):
    reply = moving(bench)
    bench.see(forward=0.2)
    bench.run(0.6, renewing(bench, reply), sense_each=2)
    bench.see(forward=3.0)
    bench.run(0.3, renewing(bench, reply), sense_each=2)
    assert bench.wheels[0] > 0.3
