"""Turns by an angle and to a heading: where they end, and what ends them sooner."""

from math import inf, isnan, nan

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from msgspec.structs import replace

from lbr.messages.drive import CheckVerdict, DriveCommand, HeadingCommand, TurnCommand
from lbr.operations.drive import command, heading_view
from lbr.operations.drive.kernel import drive_state
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.turn_goal import TurnGoal, driven, fault, power, start, watch
from tests.operations.drive.drive_bench import Bench
from tests.operations.drive.drive_body import Body

STILL = (0.0, 0.0)


@pytest.fixture
def body():
    return Body()


def renewed(body, lease, angle_deg=90.0):
    return lambda: body.turn(angle_deg, lease=lease)


def turning(body, angle_deg=90.0, ticks=20):
    """Begin a turn and let it run for a while."""
    reply = body.turn(angle_deg)
    assert reply.accepted, reply.reason
    go_on(body, reply, ticks, angle_deg)
    assert body.wheels != STILL
    return reply


def go_on(body, reply, ticks, angle_deg=90.0):
    for tick in range(ticks):
        if tick % 5 == 0:
            body.sense()
            body.turn(angle_deg, lease=reply.lease)
        body.step()


# where they end


@pytest.mark.parametrize(
    ("rate_dps", "away_deg", "ends"), [(0.0, 4.9, False), (0.0, 5.1, True), (-4.0, 6.9, False), (-4.0, 7.1, True)]
)
def test_a_base_may_get_a_little_farther_from_its_target_and_by_what_it_turned_already(rate_dps, away_deg, ends):
    settings = DriveSettings()
    heading = heading_view.HeadingView(trouble="", epoch="e", turned_deg=0.0, rate_dps=rate_dps, seen=10.0)
    turn = start(TurnCommand(angle_deg=30.0), heading, settings, 10.0)
    turn = watch(turn, replace(heading, turned_deg=-away_deg, rate_dps=0.0, seen=10.05), 0.3, settings)
    found = fault(turn, settings, 10.05)
    assert (found.code if found else "") == ("not_followed" if ends else "")


def test_the_older_an_attitude_is_the_nearer_its_target_a_turning_base_is_taken_to_be():
    settings = DriveSettings()
    heading = heading_view.HeadingView(trouble="", epoch="e", turned_deg=80.0, rate_dps=20.0, seen=10.0)
    turn = replace(start(TurnCommand(angle_deg=90.0), heading, settings, 10.0), begun_deg=60.0)
    fresh, older = (power(turn, settings, 10.0 + age_s) for age_s in (0.0, 0.1))
    least = power(replace(turn, heading=replace(heading, turned_deg=149.0, rate_dps=0.0)), settings, 10.0)
    assert fresh >= older >= least
    near = replace(turn, heading=replace(heading, turned_deg=145.0))
    assert power(near, settings, 10.0) > 0.0
    assert power(near, settings, 10.3) == 0.0


def test_the_power_of_late_turns_the_base_after_its_lag():
    settings = DriveSettings()
    heading = heading_view.HeadingView(trouble="", epoch="e", turned_deg=0.0, seen=10.0)
    turn = start(TurnCommand(angle_deg=90.0), heading, settings, 10.0)
    half = driven(turn, 0.4, settings.turn_lag_s / 2, settings)
    assert half.flow_dps == pytest.approx(0.4 * settings.max_turn_dps / 2)
    assert driven(half, 0.4, settings.turn_lag_s, settings).flow_dps == pytest.approx(0.4 * settings.max_turn_dps)
    assert (half.tries, half.given) == (1, 0.4)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(("rate_dps", "flow_dps"), [(-10.0, 0.0), (0.0, -10.0), (-10.0, 10.0), (10.0, -10.0)])
def test_a_base_that_turns_away_or_soon_will_comes_to_rest_before_it_turns_back(sense, rate_dps, flow_dps):
    settings = DriveSettings()
    heading = heading_view.HeadingView(trouble="", epoch="e", turned_deg=0.0, rate_dps=sense * rate_dps, seen=10.0)
    turn = replace(start(TurnCommand(angle_deg=sense * 90.0), heading, settings, 10.0), flow_dps=sense * flow_dps)
    assert power(turn, settings, 10.0) == 0.0
    quiet = replace(turn, heading=replace(heading, rate_dps=0.0), flow_dps=0.0)
    assert sense * power(quiet, settings, 10.0) > 0.0


@pytest.mark.parametrize(
    ("counts", "times"),
    [
        ({"tries": 3}, 1.0),
        ({"tries": 4}, 1.5),
        ({"tries": 5}, 2.0),
        ({"tries": 99}, 4.0),
        ({"swings": 1}, 1.0),
        ({"swings": 2}, 2.0),
        ({"swings": 99}, 4.0),
    ],
)
def test_each_correction_in_vain_widens_the_tolerance_and_by_four_times_at_most(counts, times):
    settings = DriveSettings()
    heading = heading_view.HeadingView(trouble="", epoch="e", turned_deg=0.0, seen=10.0)
    turn = TurnGoal(asked_deg=0.0, begun_deg=0.0, epoch="e", heading=heading, ends=20.0, allowed_s=10.0, **counts)
    near, far = (replace(turn, asked_deg=sign * times * settings.turn_tolerance_deg) for sign in (0.99, 1.01))
    assert power(near, settings, 10.0) == 0.0
    assert power(far, settings, 10.0) != 0.0
    rested = [watch(one, replace(heading, seen=10.1), 0.0, settings) for one in (near, far)]
    assert [isnan(one.quiet) for one in rested] == [False, True]


@pytest.mark.parametrize("angle_deg", [-360.0, -90.0, -3.0, 2.0, 10.0, 90.0, 180.0, 360.0])
def test_a_turn_ends_at_its_angle_and_tells_its_error(body, angle_deg):
    result = body.turned(angle_deg)
    assert result.result == "reached"
    assert body.turned_deg - 1000.0 == pytest.approx(angle_deg, abs=1.5)
    assert result.turned_deg == pytest.approx(body.turned_deg - 1000.0, abs=0.01)
    assert result.error_deg == pytest.approx(result.turned_deg - angle_deg, abs=0.02)
    assert body.farthest_deg <= abs(angle_deg) + 3.0


def test_a_turn_is_told_in_degrees(body):
    result = body.turned(90.0)
    (told,) = [event for event in body.events if event.kind == "turned"]
    assert told.text == f"console: {result.reason}"
    assert result.reason.startswith(f"turned {result.turned_deg:.1f} of 90 degrees in {result.elapsed_s:.1f} s, ")


@given(
    angle_deg=st.floats(-360.0, 360.0),
    late=st.integers(0, 5),
    lazy=st.floats(0.0, 0.8),
    gain=st.floats(0.4, 1.5),
)
def test_bases_of_all_sorts_end_near_their_target_in_time(angle_deg, late, lazy, gain):
    body = Body(late=late, lazy=lazy)
    body.gain = gain
    result = body.turned(angle_deg)
    assert (result.result, abs(result.error_deg) < 2.0) == ("reached", True)
    assert body.farthest_deg < abs(angle_deg) + 20.0


@pytest.mark.parametrize(
    ("heading_deg", "wanted_deg", "way_deg"),
    [(10.0, 350.0, -20.0), (350.0, 10.0, 20.0), (0.0, 180.0, 180.0), (90.0, 90.0, 0.0), (90.0, 271.0, -179.0)],
)
def test_a_heading_is_reached_by_the_shorter_way_and_clockwise_if_both_are_as_long(heading_deg, wanted_deg, way_deg):
    assert heading_view.shortest_deg(heading_deg, wanted_deg) == way_deg
    body = Body(offset_deg=heading_deg - 1000.0)
    result = body.headed(wanted_deg)
    assert (result.result, result.turned_deg) == ("reached", pytest.approx(way_deg, abs=1.5))


def test_a_compass_that_moves_during_the_turn_does_not_move_its_target(body):
    body.offset_deg = -1000.0
    body.step()
    reply = body.head(90.0)
    body.offset_deg -= 40.0
    result = body.until_over(reply, lambda lease: body.head(90.0, lease=lease))
    assert result.turned_deg == pytest.approx(90.0, abs=1.5)


def test_the_wheels_only_spin_and_no_faster_than_set():
    body = Body(turn_power=0.3)
    body.turned(270.0)
    assert all(setpoint.left == -setpoint.right for setpoint in body.setpoints)
    assert max(setpoint.left for setpoint in body.setpoints) == pytest.approx(0.3)


def test_an_overshoot_is_corrected_at_low_power():
    body = Body(lazy=0.9)
    reply = body.turn(30.0)
    result = body.until_over(reply, lambda lease: body.turn(30.0, lease=lease))
    assert result.result == "reached"
    assert min(setpoint.left for setpoint in body.setpoints) < 0.0
    assert abs(result.error_deg) < 2.0


class Sticky(Body):
    """A body that stands until it is pushed by `sticks`, and then turns by less."""

    sticks = 0.12

    def step(self):
        left, right = self._wheels[0]
        moves = abs(left - right) / 2 >= (self.sticks if abs(self.rate_dps) < 2.0 else 0.04)
        self.gain = 1.0 if moves else 0.0
        super().step()


@given(
    angle_deg=st.floats(-360.0, 360.0), late=st.integers(0, 3), lazy=st.floats(0.0, 0.8), sticks=st.floats(0.0, 0.15)
)
@example(angle_deg=13.783, late=1, lazy=0.775, sticks=0.1423)  # corrections of 3.6 degrees, to and fro
@example(angle_deg=-12.187, late=3, lazy=0.284, sticks=0.1474)
def test_a_base_that_sticks_gets_what_it_needs_and_no_more(angle_deg, late, lazy, sticks):
    body = Sticky(late=late, lazy=lazy)
    body.sticks = sticks
    result = body.turned(angle_deg)
    assert (result.result, abs(result.error_deg) < 4.0) == ("reached", True)


# what is refused


@pytest.mark.parametrize(
    ("attitude", "turn_about", "heading_about"),
    [
        ({"valid": False, "reason": "no sample yet"}, ("attitude", ": no sample yet"), ("no sample yet",)),
        ({"turned_deg": None}, ("attitude", "no sense"), ("no sense",)),
        ({"turned_deg": nan}, ("attitude", "no sense"), ("no sense",)),
        ({"measured_s": nan}, ("attitude", "no sense"), ("no sense",)),
        ({"measured_s": 99.0}, ("attitude", "older", "0.2 s"), ("older",)),
        ({"heading_deg": None, "heading_reason": "iron is near"}, (), ("heading", ": iron is near")),
        ({"heading_deg": nan}, (), ("heading", "not measured")),
        ({"heading_deg": 361.0}, (), ("heading",)),
    ],
)
def test_what_the_attitude_does_not_allow_is_refused_with_its_reason(body, attitude, turn_about, heading_about):
    body.attitude = attitude
    body.now += 0.25
    body.tell()
    said = body.turn(90.0)
    assert (said.accepted, said.code) == ((False, "stale_sensor") if turn_about else (True, ""))
    assert all(name in said.reason for name in turn_about), said.reason
    body.stop()
    body.now += 0.01
    said = body.head(90.0)
    assert (said.accepted, said.code) == (False, "stale_sensor")
    assert all(name in said.reason for name in heading_about), said.reason


def test_nothing_turns_before_an_attitude_was_heard():
    bench = Bench()
    assert bench.turn(90.0).code == "stale_sensor"
    assert bench.head(90.0).code == "stale_sensor"


@pytest.mark.parametrize("angle_deg", [nan, inf, 361.0, -361.0])
def test_nonsense_is_refused_and_named(body, angle_deg):
    assert "angle_deg" in body.turn(angle_deg).reason
    assert "heading_deg" in body.head(angle_deg).reason


def test_turns_pass_the_same_chain_as_other_motion(body):
    assert body.turn(90.0, checks={"cliff": CheckVerdict(accepted=False, reason="a cliff")}).reason == (
        "check cliff: a cliff"
    )
    body.estop(True)
    assert body.turn(90.0).reason.startswith("emergency stop")
    body.estop(False)
    body.run(0.3)
    body.tell()
    assert body.drive(0.2).accepted
    body.now += 0.01
    assert body.turn(90.0, source="phone").reason == "held by console; stop it first"
    assert body.turn(90.0, source="phone", take_over=True).accepted
    body.stop()
    body.now += 0.01
    body.see(left=0.1)
    assert body.turn(90.0).reason.startswith("left 0.10 m is inside 0.20 m")


def test_from_another_machine_a_turn_begins_only_when_its_lease_is_quoted(body):
    offer = body.turn(90.0, source="page", remote=True)
    assert offer.goal
    body.step()
    assert body.wheels == STILL
    body.turned_deg += 1.0
    body.step()
    assert body.turn(90.0, source="page", remote=True, lease=offer.lease).goal == offer.goal
    go_on(body, offer, 10)
    assert body.wheels != STILL
    assert body.state.lease.motion.goal.turn.begun_deg == 1001.0, (
        "it turns from where it began, not from where it was asked"
    )


def test_a_check_is_shown_the_spin_and_what_was_asked():
    settings = DriveSettings()
    left = command.check_request("page", TurnCommand(angle_deg=-30.0), settings)
    assert (left.command.power, left.command.angle_deg, left.turn.angle_deg) == (0.2, -90.0, -30.0)
    there = command.check_request("page", HeadingCommand(heading_deg=270.0), settings)
    assert (there.command.power, there.heading.heading_deg, there.turn) == (0.2, 270.0, None)
    plain = DriveCommand(power=0.4)
    assert command.check_request("page", plain, settings).command is plain


# what ends them


def test_a_turn_lives_by_its_lease(body):
    turning(body)
    for _ in range(16):
        body.step()
        body.sense()
    assert body.wheels == STILL
    assert [r.result for r in body.results] == ["lapsed"]


def test_a_renewal_goes_on_with_the_turn_and_another_command_supersedes_it(body):
    reply = turning(body)
    begun = body.state.lease.motion.goal.turn.begun_deg
    assert body.turn(90.0, lease=reply.lease).goal == reply.goal
    assert body.state.lease.motion.goal.turn.begun_deg == begun
    body.step()  # what is said in the same moment as a renewal counts as overtaken by it
    changed = body.turn(-45.0, lease=reply.lease)
    assert (changed.accepted, changed.lease, changed.goal != reply.goal) == (True, reply.lease, True)
    assert [(r.result, r.reason) for r in body.results] == [("superseded", "another command came")]
    assert body.results[0].turned_deg > 5.0
    assert body.until_over(changed, lambda lease: body.turn(-45.0, lease=lease)).result == "reached"
    assert not body.turn(-45.0, lease=reply.lease).accepted


def test_driving_supersedes_a_turn_under_its_lease(body):
    reply = turning(body)
    assert body.drive(0.3, lease=reply.lease).accepted
    assert body.results[-1].result == "superseded"
    body.run(0.2, lambda: body.drive(0.3, lease=reply.lease))
    assert body.wheels[0] == body.wheels[1] > 0.0


def lose_attitude(body):
    body.attitude_speaks = False


@pytest.mark.parametrize(
    ("how", "code", "about"),
    [
        (lose_attitude, "stale_sensor", ("attitude", "older", "0.2 s")),
        (lambda b: b.attitude.update(valid=False, reason="iron"), "stale_sensor", ("attitude", ": iron")),
        (lambda b: b.attitude.update(epoch="e2"), "stale_sensor", ("attitude", "started over")),
        (lambda b: b.attitude.update(turned_deg=nan), "stale_sensor", ("attitude", "no sense")),
        (lambda b: b.attitude.update(turned_deg=None), "stale_sensor", ("attitude", "no sense")),
        (lambda b: b.attitude.update(turned_deg=1300.0), "stale_sensor", ("attitude", "jumped")),
        (lambda b: b.attitude.update(measured_s=b.now), "stale_sensor", ("attitude", "older", "0.2 s")),
        (lambda b: setattr(b, "gain", 0.0), "stuck", ("1 s", " 0.")),
        (lambda b: setattr(b, "side", -1.0), "not_followed", ("away",)),
        (lambda b: b.lose_motors(), "unreachable", ("motors is gone",)),
        (lambda b: b.estop(True), "estop", ("button",)),
    ],
)
def test_what_ends_a_turn_is_a_fault_with_a_sentence(body, how, code, about):
    reply = turning(body, 180.0, ticks=15)
    how(body)
    go_on(body, reply, 75, 180.0)
    assert body.wheels == STILL
    (result,) = body.results
    assert (result.result, result.code) == ("fault", code)
    assert all(name in result.reason for name in about), result.reason
    assert not body.turn(180.0, lease=reply.lease).accepted


def test_a_turn_that_takes_too_long_is_a_fault_with_what_it_came_to():
    body = Body(turn_spare_s=0.5)
    body.gain = 0.25
    reply = body.turn(90.0)
    result = body.until_over(reply, lambda lease: body.turn(90.0, lease=lease))
    assert result.result == "fault"
    assert result.reason.startswith("not within 2.8 s: turned ")
    assert body.wheels == STILL


def test_a_wall_beside_it_holds_a_turn_still_and_ends_it_after_a_second(body):
    reply = turning(body, 180.0, ticks=15)
    body.see(left=0.1)
    go_on(body, reply, 2, 180.0)
    assert body.wheels == STILL
    go_on(body, reply, 60, 180.0)
    assert [(r.result, r.reason) for r in body.results] == [
        ("stopped", "held still for 1 s: left 0.10 m is inside 0.25 m")
    ]


def test_a_turn_shows_as_a_spin(body):
    turning(body, -90.0)
    state = drive_state(body.state, body.now)
    assert (state.power, state.angle_deg, state.moving, state.goal) == (0.2, -90.0, True, "goal1")


numbers = st.one_of(st.floats(), st.none())


@given(fields=st.lists(st.tuples(st.booleans(), numbers, numbers, st.floats(), st.sampled_from("ab")), max_size=12))
@example(fields=[(True, 1000.0, 0.0, nan, "a")])
@example(fields=[(True, inf, inf, inf, "a")])
def test_whatever_the_attitude_says_the_wheels_stay_within_bounds_and_stop(fields):
    body = Body()
    reply = body.turn(90.0)
    for valid, turned_deg, heading_deg, measured_s, epoch in fields:
        body.attitude = {
            "valid": valid, "turned_deg": turned_deg, "heading_deg": heading_deg, "measured_s": measured_s, "epoch": epoch
        }  # fmt: skip
        body.turn(90.0, lease=reply.lease)
        body.step()
        left, right = body.wheels
        assert -0.2 <= left == -right <= 0.2
    lose_attitude(body)
    for _ in range(15):
        body.sense()
        body.turn(90.0, lease=reply.lease)
        body.step()
    assert body.wheels == STILL
