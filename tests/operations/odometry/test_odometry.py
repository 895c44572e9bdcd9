"""Odometry: what counts and attitude make of a way, and what it says when they make no sense."""

from math import inf, nan, pi, radians

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.messages.attitude import AttitudeState
from lbr.messages.motors import MotorsState
from lbr.operations.odometry import KIND, OdometrySettings
from lbr.operations.odometry.capability import Odometry
from lbr.operations.odometry.reckoning import Reckoning
from lbr.testing import FakeContext

PER_COUNT_M = pi * 0.1778 / 130
PERIOD_S = 0.1


class Base:
    """Wheels that count, a body that turns, and the reckoning that hears of both at 10 Hz."""

    def __init__(self, **fields):
        self.reckoning = Reckoning(OdometrySettings(**fields), "test")
        self.now = 50.0
        self.left = self.right = 0.0
        self.offset = 0
        self.power = (0.0, 0.0)
        self.amps = (None, None)
        self.look = None
        self.tell()

    def tell(self, **fields):
        if self.look is not None:
            self.see(self.look)
        counts = {"counts_left": self._count(self.left), "counts_right": self._count(self.right)}
        told = {"left": self.power[0], "right": self.power[1], "armed": True, "reason": "", "estop": False} | counts
        amps = {"amps_left_a": self.amps[0], "amps_right_a": self.amps[1]}
        self.reckoning.count(MotorsState(**(told | amps | fields)), self.now)
        return self.reckoning.state()

    def see(self, turned_deg, **fields):
        told = {"valid": True, "epoch": "a", "measured_s": self.now, "turned_deg": turned_deg} | fields
        self.reckoning.look(AttitudeState(**told))

    def roll(self, left_m, right_m, rounds=10, **fields):
        """Roll the wheels in equal steps; return the last state."""
        for _ in range(rounds):
            self.now = round(self.now + PERIOD_S, 6)
            self.left += left_m / rounds
            self.right += right_m / rounds
            state = self.tell(**fields)
        return state

    def _count(self, way_m):
        turned = round(way_m / PER_COUNT_M) + self.offset
        return (turned + 2**31) % 2**32 - 2**31


@pytest.fixture
def base():
    return Base()


def test_nothing_is_known_before_the_motors_spoke(wording):
    state = Reckoning(OdometrySettings(), "test").state()
    assert (state.valid, state.distance_m) == (False, None)
    wording(state.reason)


@pytest.mark.parametrize("way_m", [2.0, -1.5])
def test_straight_on_is_distance_and_speed(base, way_m):
    state = base.roll(way_m, way_m, rounds=20)
    assert state.valid
    assert (state.x_m, state.y_m, state.distance_m) == pytest.approx((way_m, 0.0, way_m), abs=0.01)
    assert state.speed_mps == pytest.approx(way_m / 2, abs=0.03)
    assert state.turn_rps == pytest.approx(0.0, abs=0.03)
    assert (state.stalled, state.slipping) == (False, False)


def test_after_a_rest_speeds_count_from_the_beginning_of_the_motion(base):
    base.roll(0.0, 0.0, 1, rests=True)
    base.now = round(base.now + 0.45, 6)
    assert base.tell(rests=True).rests
    base.now = round(base.now + 0.4, 6)
    began = base.tell()
    assert (began.valid, began.rests, began.speed_mps) == (True, False, 0.0)
    assert base.roll(0.05, 0.05, 1).speed_mps == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize(("rests", "silent_s"), [(False, 0.3), (True, 1.2)])
def test_motors_that_rest_may_be_silent_for_longer(base, rests, silent_s):
    base.roll(0.0, 0.0, 1, rests=rests)
    base.reckoning.silence(base.now + silent_s - 0.01)
    assert base.reckoning.state().valid
    base.reckoning.silence(base.now + silent_s + 0.01)
    assert base.reckoning.state().reason == f"the motor driver has been silent for more than {silent_s} s"


def test_wheels_that_differ_turn_the_base(base):
    quarter_m = pi / 2 * 0.27
    state = base.roll(0.0, quarter_m, rounds=30)
    assert state.yaw_rad == pytest.approx(pi / 2, abs=0.03)
    assert (state.x_m, state.y_m) == pytest.approx((0.135, 0.135), abs=0.01)


def test_the_attitude_turns_the_base_if_it_is_known(base):
    for turned_deg in range(0, 91, 3):
        base.look = float(turned_deg)
        state = base.roll(0.01, 0.01, rounds=1)
    assert state.yaw_rad == pytest.approx(-pi / 2, abs=0.001), "clockwise is negative here"
    assert state.y_m < -0.1


@pytest.mark.parametrize(
    "fields", [{"valid": False}, {"turned_deg": None}, {"turned_deg": nan}, {"measured_s": 1.0}, {"epoch": "b"}]
)
def test_an_attitude_that_is_not_known_turns_nothing(base, fields):
    base.see(0.0)
    base.roll(0.1, 0.1, rounds=1)
    base.see(**({"turned_deg": 90.0} | fields))
    assert base.roll(0.1, 0.1, rounds=1).yaw_rad == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize(("comes", "turned_rad"), [(True, -pi / 2), (False, 0.22)], ids=["it comes", "it is lost"])
def test_an_attitude_at_rest_is_known_until_the_wheels_have_moved_for_a_while(base, comes, turned_rad):
    base.see(0.0, rests=True)
    for _ in range(3):
        base.roll(0.0, 0.0, rounds=3, rests=True)
    assert base.roll(0.01, 0.01, rounds=1).yaw_rad == pytest.approx(0.0, abs=0.001)
    base.roll(0.01, 0.01, rounds=1)
    for turned_deg in range(0, 91, 3):
        base.look = float(turned_deg) if comes else None
        state = base.roll(0.01, 0.012, rounds=1)
    assert state.yaw_rad == pytest.approx(turned_rad, abs=0.03), "by the body, or by the wheels"


@pytest.mark.parametrize("sense", [1, -1])
def test_counts_go_round_without_a_jump(sense):
    base = Base()
    base.offset = sense * (2**31 - 50)
    base.tell()
    epoch = base.roll(0.0, 0.0, rounds=1).epoch
    state = base.roll(sense * 1.0, sense * 1.0)
    assert (state.distance_m, state.epoch) == (pytest.approx(sense * 1.0, abs=0.01), epoch)


def test_a_controller_that_counts_anew_begins_another_epoch(base):
    before = base.roll(1.0, 1.0)
    base.offset = -round(base.left / PER_COUNT_M)
    state = base.roll(0.0, 0.0, rounds=1)
    assert (state.valid, state.distance_m, state.epoch != before.epoch) == (True, 0.0, True)
    assert base.roll(0.5, 0.5).distance_m == pytest.approx(0.5, abs=0.01)


def test_without_encoders_nothing_is_known_and_the_reason_is_told(base):
    state = base.roll(0.1, 0.1, counts_left=None)
    assert (state.valid, state.x_m) == (False, None)
    assert "no encoder counts" in state.reason
    state = base.roll(0.1, 0.1, counts_right=None, armed=False, reason="the line is closed")
    assert state.reason.endswith("(the line is closed)")
    assert base.roll(0.1, 0.1).valid


def test_motors_that_fall_silent_make_it_unknown_and_it_begins_anew(base):
    before = base.roll(0.3, 0.3)
    base.reckoning.silence(base.now + 0.29)
    assert base.reckoning.state().valid
    base.reckoning.silence(base.now + 0.31)
    assert "silent for more than 0.3 s" in base.reckoning.state().reason
    after = base.roll(0.1, 0.1)
    assert (after.valid, after.epoch != before.epoch) == (True, True)


@pytest.mark.parametrize(
    ("power", "amps"), [((0.3, 0.3), (None, None)), ((0.0, 0.3), (0.1, 9.0)), ((0.01, 0.0), (8.0, 0.0))]
)
def test_wheels_that_are_pushed_and_stand_for_half_a_second_are_stalled(base, power, amps):
    base.power, base.amps = power, amps
    assert not base.roll(0.0, 0.0, rounds=4).stalled
    assert base.roll(0.0, 0.0, rounds=2).stalled
    assert not base.roll(0.1, 0.1, rounds=1).stalled
    base.power, base.amps = (0.0, 0.0), (0.0, 0.0)
    assert not base.roll(0.0, 0.0, rounds=20).stalled


def test_wheels_that_turn_while_the_body_does_not_are_slipping(base):
    base.look = 0.0
    base.roll(0.1, 0.1)
    assert not base.reckoning.state().slipping
    assert base.roll(0.4, -0.4).slipping
    assert not base.roll(0.2, 0.2, rounds=20).slipping


def test_a_body_that_turns_as_its_wheels_say_does_not_slip(base):
    for _ in range(30):
        base.look = (base.look or 0.0) + 5.0
        arc_m = radians(5.0) * 0.27 / 2
        assert not base.roll(arc_m, -arc_m, rounds=1).slipping


counts = st.one_of(st.none(), st.integers(-(2**40), 2**40))
numbers = st.one_of(st.none(), st.floats())


@given(told=st.lists(st.tuples(counts, counts, st.floats(), numbers, st.booleans(), numbers, st.floats()), max_size=10))
def test_whatever_is_told_the_state_is_made_of_numbers_or_is_not_valid(told):
    base = Base()
    for left, right, power, amps, valid, turned_deg, time_s in told:
        base.see(turned_deg, valid=valid, measured_s=time_s)
        base.now = time_s
        base.tell(counts_left=left, counts_right=right, left=power, right=power, amps_left_a=amps)
        base.reckoning.silence(base.now)
        state = base.reckoning.state()
        shown = (state.x_m, state.y_m, state.yaw_rad, state.distance_m, state.speed_mps, state.turn_rps)
        assert all(-inf < value < inf for value in shown) if state.valid else set(shown) == {None}


def test_the_process_answers_each_state_of_the_motors_and_speaks_when_they_are_silent(wording):
    context = FakeContext(KIND, OdometrySettings(), name="odometry")
    odometry = Odometry(context)
    odometry.open()
    motors = MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False, counts_left=5, counts_right=7)
    for _ in range(3):
        context.now += 0.1
        context.arrive("motors", motors)
        odometry.step()
    assert [message.valid for message in context.said("state")] == [False, True, True, True]
    for _ in range(25):
        context.now += 0.04
        odometry.step()
    wording(context.said("state")[-1].reason)
    assert len(context.said("state")) == 5


def test_the_process_goes_round_only_for_the_motors_and_to_publish_their_silence():
    context = FakeContext(KIND, OdometrySettings(), name="odometry")
    odometry = Odometry(context)
    odometry.open()
    motors = MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False, counts_left=5, counts_right=7)
    context.arrive("motors", motors)
    odometry.step()
    assert odometry.rate_hz == 2.0
    context.now += 0.4
    odometry.step()
    assert (odometry.rate_hz, len(context.said("state"))) == (pytest.approx(10.0), 2)
    context.now += 0.11
    odometry.step()
    assert [state.valid for state in context.said("state")] == [False, True, False]
    assert odometry.rate_hz == 2.0


def test_the_kind_names_the_class_that_runs_and_refuses_a_bad_row():
    assert KIND.load() is Odometry
    with pytest.raises(msgspec.ValidationError, match="wheel_diameter_m"):
        KIND.parse('{"wheel_diameter_m": 0}')
