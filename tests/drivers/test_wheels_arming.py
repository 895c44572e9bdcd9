from math import inf, isnan, nan

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from lbr.drivers.wheels.arming import RESTS_S, START, Arming, Inhibit, Setpoint, receive, tick

VALID_S = 0.1


def at(born, left=0.0, right=0.0, lease=""):
    return Setpoint((left, right), lease, born)


def armed(now=10.0):
    return receive(Arming(), at(now), now, VALID_S)


def moving(now=10.0, lease="L1"):
    return receive(armed(now), at(now, 0.5, 0.5, lease), now, VALID_S)


def test_only_a_zero_arms():
    refused = receive(Arming(), at(10.0, 0.5, 0.5, "L1"), 10.0, VALID_S)
    assert not refused.armed
    assert refused.applied == (0.0, 0.0)
    assert armed().armed


@pytest.mark.parametrize("powers", [(0.0, 0.5), (-0.5, 0.0)])
def test_a_setpoint_of_which_one_power_is_zero_is_no_zero(powers):
    assert not receive(Arming(), at(10.0, *powers, "L1"), 10.0, VALID_S).armed
    late = receive(tick(moving(), None, 10.11, VALID_S), at(10.12), 10.12, VALID_S)
    assert receive(late, at(10.13, *powers, "L1"), 10.13, VALID_S).applied == (0.0, 0.0)
    assert receive(armed(), at(10.0, *powers, "L1"), 10.0, VALID_S).moving


def test_a_motor_that_a_setpoint_does_not_name_is_named():
    state = receive(moving(), Setpoint((nan, 0.1), "L1", 10.0, "front_left"), 10.0, VALID_S)
    assert "'front_left'" in state.reason
    assert "finite" in receive(moving(), at(10.0, nan), 10.0, VALID_S).reason


@pytest.mark.parametrize("age_s", [0.101, 0.2, 5.0, -5.0, nan, inf])
def test_a_zero_that_is_not_fresh_does_not_arm(age_s):
    assert not receive(Arming(), at(10.0 - age_s), 10.0, VALID_S).armed


def test_a_late_setpoint_stops_and_kills_its_lease():
    late = tick(moving(), None, 10.11, VALID_S)
    assert late.applied == (0.0, 0.0)
    assert not late.armed
    assert late.trips == 1
    assert late.reason.startswith("no setpoint within 0.1 s")
    assert late.code == "no_setpoint"
    again = receive(late, at(10.12), 10.12, VALID_S)
    assert (again.armed, again.code) == (True, "")
    assert receive(again, at(10.13, 0.5, 0.5, "L1"), 10.13, VALID_S).applied == (0.0, 0.0)
    assert receive(again, at(10.13, 0.5, 0.5, "L2"), 10.13, VALID_S).applied == (0.5, 0.5)


def test_a_late_zero_while_standing_disarms_without_a_trip():
    late = tick(armed(), None, 10.11, VALID_S)
    assert not late.armed
    assert late.trips == 0


def resting(now=10.0):
    return receive(Arming(), Setpoint((0.0, 0.0), "", now, begun=now), now, VALID_S)


def test_a_zero_with_the_age_of_its_motion_stays_in_force_until_signs_of_life_are_missing():
    state = tick(resting(), None, 10.0 + RESTS_S - 0.001, VALID_S)
    assert (state.armed, state.applied) == (True, (0.0, 0.0))
    late = tick(state, None, 10.0 + RESTS_S + 0.001, VALID_S)
    assert (late.armed, late.trips) == (False, 0)
    assert late.reason.startswith("no setpoint within 1.2 s")


@pytest.mark.parametrize(("age_s", "moves"), [(0.0, True), (0.02, True), (0.099, True), (0.101, False), (nan, False)])
def test_after_a_long_rest_only_a_motion_that_has_just_begun_is_obeyed(age_s, moves):
    begins = Setpoint((0.1, 0.1), "L1", 11.0, begun=11.0 - age_s)
    state = receive(resting(), begins, 11.0, VALID_S)
    assert (state.moving, state.armed) == (moves, moves)
    if not moves:
        again = receive(receive(state, at(11.02), 11.02, VALID_S), at(11.03, 0.1, 0.1, "L1"), 11.03, VALID_S)
        assert not again.moving
        assert (state.trips, state.reason) == (0, f"the beginning of this motion was missed; {START}")


def test_a_motion_lapses_as_ever_after_a_zero_that_stays():
    moves = receive(resting(), Setpoint((0.1, 0.1), "L1", 11.0, begun=11.0), 11.0, VALID_S)
    assert not tick(moves, None, 11.0 + VALID_S + 0.001, VALID_S).armed


@pytest.mark.parametrize("power", [nan, inf, -inf])
def test_a_power_that_is_no_number_stops_and_disarms(power):
    state = receive(moving(), at(10.01, power, 0.1, "L1"), 10.01, VALID_S)
    assert state.applied == (0.0, 0.0)
    assert not state.armed
    assert state.trips == 1
    assert state.dead == ("L1",)


@pytest.mark.parametrize(("fault", "trips"), [(True, 1), (False, 0)])
def test_an_inhibit_stops_at_once_and_a_zero_from_before_does_not_arm_after_it(fault, trips):
    state = tick(moving(), Inhibit("emergency stop", fault=fault), 10.05, VALID_S)
    assert state.applied == (0.0, 0.0)
    assert state.reason == "emergency stop"
    assert state.trips == trips
    assert not receive(state, at(10.06), 10.06, VALID_S).armed
    released = tick(state, None, 10.07, VALID_S)
    assert not receive(released, at(10.049), 10.08, VALID_S).armed
    assert receive(released, at(10.08), 10.08, VALID_S).armed
    assert not receive(released, at(10.08, 0.5, 0.5, "L9"), 10.08, VALID_S).armed


powers = st.sampled_from([0.0, 0.0, 0.3, -1.0, nan, inf])
leases = st.sampled_from(["", "L1", "L2", "L3"])


class AnyHistory(RuleBasedStateMachine):
    """Whatever happens in whatever order, power at the wheels is always accounted for."""

    def __init__(self):
        super().__init__()
        self.now = 100.0
        self.state = Arming()
        self.inhibit = None
        self.buried = set()
        self.zero_since_disarm = False

    def _advance(self, after):
        before, self.state = self.state, after
        if before.moving and not after.armed and before.setpoint.lease:
            self.buried.add(before.setpoint.lease)
        if before.armed and not after.armed:
            self.zero_since_disarm = False

    @rule(
        left=powers,
        right=powers,
        lease=leases,
        age_s=st.sampled_from([0.0, 0.05, 0.099, 0.101, 0.5, nan]),
        moving_s=st.sampled_from([0.0, 0.04, 0.2, nan]),
    )
    def a_setpoint_comes(self, left, right, lease, age_s, moving_s):
        born = self.now - age_s
        setpoint = Setpoint((left, right), lease, born, begun=born - (moving_s if left or right else moving_s * 0.0))
        was_armed, before = self.state.armed, self.state.setpoint
        self._advance(receive(self.state, setpoint, self.now, VALID_S))
        if not was_armed and self.state.armed:
            assert setpoint.neutral
            assert age_s < VALID_S
            self.zero_since_disarm = True
        if self.state.moving and self.state.setpoint is setpoint:
            assert was_armed
            assert lease not in self.buried
            heard_s = self.now - (before.born if before.neutral else self.now)
            assert (
                min(heard_s, inf if isnan(setpoint.begun) else self.now - setpoint.begun) < VALID_S or not before.stays
            )

    @rule(passed_s=st.sampled_from([0.0, 0.02, 0.09, 0.11, 3.0]))
    def time_passes(self, passed_s):
        self.now += passed_s
        self._advance(tick(self.state, self.inhibit, self.now, VALID_S))
        if self.state.armed:
            assert self.now - self.state.setpoint.born < (RESTS_S if self.state.setpoint.stays else VALID_S)

    @rule(fault=st.booleans())
    def something_forbids_motion(self, fault):
        self.inhibit = Inhibit("forbidden", fault=fault)
        self._advance(tick(self.state, self.inhibit, self.now, VALID_S))
        assert self.state.applied == (0.0, 0.0)

    @precondition(lambda self: self.inhibit is not None)
    @rule()
    def it_ends(self):
        self.inhibit = None
        self.now += 0.01
        self._advance(tick(self.state, None, self.now, VALID_S))
        assert not self.state.armed

    @invariant()
    def power_needs_arming_and_arming_needs_a_zero(self):
        if self.state.moving:
            assert self.zero_since_disarm
            assert self.inhibit is None
        if not self.state.armed:
            assert self.state.applied == (0.0, 0.0)
            assert self.state.reason


TestAnyHistory = AnyHistory.TestCase
