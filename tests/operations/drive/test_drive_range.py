"""A range that is asked for is where the base comes to rest: braked before it, and never later than its readings end it."""

from random import Random

import pytest
from msgspec.structs import replace

from lbr.operations.drive.odometry_view import UNKNOWN
from lbr.operations.drive.range_goal import NOISE_M, RangeGoal, driven, is_over, power, read
from lbr.operations.drive.settings import DriveSettings
from tests.operations.drive.drive_bench import ranges
from tests.operations.drive.drive_body import TICK_S, Body

STILL = (0.0, 0.0)
CYCLE_TICKS, CYCLE_S = 6, 0.12


class Walled(Body):
    """A body before a wall, whose sonar tells whole centimetres at eight times a second, some ticks late."""

    def __init__(self, wall_m, *, noise_m=0.0, seed=0, age_ticks=3, tells_age=False, **settings):
        self._dice, self._noise_m, self._age_ticks = Random(seed), noise_m, age_ticks
        self._ages_s = {"forward": age_ticks * TICK_S} if tells_age else {}
        self._wall_m, self._ticks, self._told = wall_m, 0, {}
        super().__init__(**settings)
        self.ranges_speak = self.attitude_speaks = False
        self.see(forward=round(wall_m, 2))

    @property
    def rests_cm(self):
        return (self._wall_m - self.way_m) * 100

    def step(self):
        self._ticks += 1
        if self._ticks % CYCLE_TICKS == 0:
            metres = self.rests_cm / 100 + self._dice.gauss(0.0, self._noise_m)
            self._told[self._ticks + self._age_ticks] = round(metres, 2)
        if (metres := self._told.pop(self._ticks, None)) is not None:
            self.around = replace(ranges(forward=metres), cycle_s=CYCLE_S, ages_s=self._ages_s)
            self.ranges_speak = True
            self.sense()
            self.ranges_speak = False
        super().step()

    def asked(self, power, range_cm, **more):
        """Drive to a range, and return its result once the base is at rest."""
        command = {"power": power, "range_cm": range_cm, **more}
        found = self.until_over(self.drive(**command), lambda lease: self.drive(**command, lease=lease))
        for _ in range(50):
            self.step()
        assert (self.wheels, abs(self.speed_mps) < 1e-3) == (STILL, True)
        return found


@pytest.mark.parametrize("power", [0.1, 0.2, 0.25, 0.4, 0.8])
@pytest.mark.parametrize("range_cm", [30.0, 40.0, 57.0])
@pytest.mark.parametrize("late", [1, 3])
def test_a_range_that_is_asked_for_is_where_the_base_rests(power, range_cm, late):
    base = Walled(1.6, late=late)
    found = base.asked(power, range_cm)
    assert found.result == "reached"
    assert base.rests_cm == pytest.approx(range_cm, abs=1.0)


@pytest.mark.parametrize("power", [0.25, 0.6])
def test_so_is_one_to_back_away_to(power):
    base = Walled(0.6)
    assert base.asked(power, 90.0, angle_deg=180.0).result == "reached"
    assert base.rests_cm == pytest.approx(90.0, abs=1.0)


def test_it_does_without_an_odometry():
    base = Walled(1.6)
    base.odometry_speaks = False
    base.count(valid=False)
    assert base.asked(0.25, 57.0).result == "reached"
    assert base.rests_cm == pytest.approx(57.0, abs=1.5)


def test_a_sonar_that_wavers_by_a_centimetre_is_a_centimetre_off_at_most_nearly_always():
    off = []
    for seed in range(40):
        base = Walled(1.5 + 0.01 * seed, noise_m=0.008, seed=seed)
        assert base.asked(0.25, 57.0).result == "reached"
        off.append(abs(base.rests_cm - 57.0))
    assert max(off) <= 1.5
    assert sum(one <= 1.0 for one in off) >= 38


@pytest.mark.parametrize("power", [0.25, 0.8])
def test_a_reading_counts_at_the_age_that_its_board_tells(power):
    base = Walled(1.6, age_ticks=8, tells_age=True)
    assert base.asked(power, 57.0).result == "reached"
    assert base.rests_cm == pytest.approx(57.0, abs=1.0)


def test_a_reading_that_has_passed_the_range_ends_it_at_once_at_any_speed():
    base = Walled(1.6)
    reply = base.drive(0.8, range_cm=57.0)
    for _ in range(10):
        base.step()
    assert base.wheels != STILL
    base.see(forward=0.3)
    base.ranges_speak = True
    base.sense()
    assert (base.results[-1].goal, base.results[-1].result) == (reply.goal, "reached")
    assert base.setpoints[-1].left == 0.0


def test_a_sender_that_dies_on_the_approach_stops_the_base():
    base = Walled(1.2)
    base.drive(0.25, range_cm=57.0)
    for _ in range(40):
        base.step()
    assert base.results[-1].result == "lapsed"
    assert base.wheels == STILL


def test_without_an_odometry_the_speed_of_the_base_is_that_of_its_setpoint():
    base = Walled(1.6, max_speed_mps=0.5)
    base.odometry_speaks = False
    base.count(valid=False)
    assert base.drive(0.3).accepted
    base.step()
    assert base.state.left == base.state.right > 0.0
    assert base.state.ahead_mps(base.now) == pytest.approx(base.state.left * 0.5)


# A reading at a time.

HALTING = RangeGoal(whole_m=0.03, marks=((10.0, 0.0),), halts=True)


def rests(way, left_m, readings, *, stands=True):
    """Readings of a base that stands, each after a tick."""
    for _ in range(readings):
        at_s = way.marks[-1][0] + 0.1
        way = read(way, left_m, at_s, 0.0, stands=stands)
        way = driven(way, UNKNOWN, 0.0, 0.1, at_s, DriveSettings())
    return way


@pytest.mark.parametrize(("left_m", "halts"), [(0.269, True), (0.271, False), (float("nan"), True)])
def test_it_halts_by_the_way_of_two_ticks_and_of_its_braking(left_m, halts):
    way = RangeGoal(whole_m=left_m, marks=((10.0, 0.0),))
    assert driven(way, UNKNOWN, 0.5, 0.0, 10.0, DriveSettings(brake_mps2=0.5, rate_hz=50.0)).halts is halts


@pytest.mark.parametrize(
    ("measured_s", "gone_m"), [(10.0, 0.0), (10.05, 0.02), (10.1, 0.04), (10.15, 0.045), (10.2, 0.05)]
)
def test_a_reading_counts_from_where_the_base_was_as_it_was_measured(measured_s, gone_m):
    braked = RangeGoal(whole_m=0.5, marks=((10.0, 0.0), (10.1, 0.04), (10.2, 0.05)))
    seen = read(braked, 0.5 - gone_m, measured_s, 0.0, stands=False)
    assert seen.whole_m == pytest.approx(0.5)


def test_a_base_that_rests_short_of_the_range_goes_on_after_three_readings_and_no_sooner():
    assert rests(HALTING, 0.03, 2).halts
    again = rests(HALTING, 0.03, 3)
    assert (again.halts, again.rested) == (False, 0)
    assert power(again, 0.5, DriveSettings()) > 0.0
    assert power(HALTING, 0.5, DriveSettings()) == 0.0


def test_readings_while_it_rolls_are_none_at_rest():
    assert rests(rests(HALTING, 0.03, 2), 0.03, 3, stands=False).rested == 0
    assert rests(replace(HALTING, halts=False), 0.03, 1).rested == 0


@pytest.mark.parametrize(("left_m", "over"), [(0.004, True), (-0.02, True), (0.006, False)])
def test_it_is_over_after_three_readings_at_rest_within_half_a_centimetre(left_m, over):
    near = replace(HALTING, whole_m=left_m)
    assert not is_over(rests(near, left_m, 2))
    assert is_over(rests(near, left_m, 3)) is over


def test_a_reading_of_something_else_counts_alone_and_others_count_by_how_well_it_is_known():
    other = read(replace(HALTING, rested=1), 0.2, 10.0, 0.0, stands=True)
    assert (other.whole_m, other.error_m, other.rested) == (0.2, NOISE_M, 2)
    closer = read(HALTING, 0.04, 10.0, 0.0, stands=True)
    assert closer.whole_m == pytest.approx(0.035)
    assert closer.error_m < HALTING.error_m
    rolling = read(HALTING, 0.04, 10.0, 0.5, stands=False)
    assert rolling.whole_m == pytest.approx(0.03 + 0.01 * 0.01**2 / (0.01**2 + 0.01**2 + 0.025**2))
    assert read(HALTING, 0.09, 10.0, 0.5, stands=False).error_m == pytest.approx((0.01**2 + 0.025**2) ** 0.5)
