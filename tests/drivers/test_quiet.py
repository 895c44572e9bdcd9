"""When an inertial unit counts as lying still, and is asked and reported less often."""

import random

import pytest

from lbr.drivers.inertial import LATE_S, QUIET_HZ, QUIET_S, SLOW_RPS, Quiet, RestingSamples
from lbr.drivers.mpu9150 import registers
from lbr.drivers.mpu9150.compass import Compass
from lbr.messages.imu import ImuSample

GYRO_ZERO = (0.3, -0.2, 0.1)
"""What a cheap unit says at rest."""


class Unit:
    """A unit with a cheap one's noise, asked every 10 ms."""

    def __init__(self, **bands):
        self.quiet = Quiet(**bands)
        self.now = 0.0
        self._dice = random.Random(7)

    def say(self, seconds=0.01, turn_rps=0.0, push_mps2=0.0, **more):
        said = False
        for _ in range(round(seconds / 0.01)):
            self.now += 0.01
            x, y, z = (zero + self._dice.gauss(0.0, 0.0015) for zero in GYRO_ZERO)
            a, b, c = (self._dice.gauss(0.0, 0.04) for _ in range(3))
            seen = {"gyro_rps": (x, y, z + turn_rps), "accel_mps2": (a + push_mps2, b, c + 9.81), "valid": True} | more
            said = self.quiet.look(ImuSample(time_s=self.now, **seen))
        return said


@pytest.fixture
def unit():
    unit = Unit()
    assert not unit.say(QUIET_S)
    assert unit.say(0.1)
    return unit


def test_one_that_lies_still_stays_quiet_whatever_its_zero(unit):
    assert all(unit.say() for _ in range(6000))


@pytest.mark.parametrize("motion", [{"turn_rps": 0.05}, {"turn_rps": -0.05}, {"push_mps2": 0.8}])
def test_the_first_sample_of_a_motion_ends_it(unit, motion):
    assert not unit.say(**motion)


@pytest.mark.parametrize(
    "missing",
    [{"valid": False, "reason": "i2c"}, {"gyro_rps": None}, {"accel_mps2": None}],
    ids=["all", "gyro", "accel"],
)
def test_what_is_not_measured_ends_it_and_is_not_what_later_samples_are_like(unit, missing):
    assert not unit.say(**missing)
    assert not unit.say(QUIET_S / 2)
    assert unit.say(QUIET_S / 2 + 0.1)


@pytest.mark.parametrize(("band", "motion"), [("still_rps", {"turn_rps": 0.05}), ("still_mps2", {"push_mps2": 0.8})])
def test_a_row_with_a_wider_band_calls_more_of_it_noise(band, motion):
    shaken = Unit(**{band: 1.0})
    assert [shaken.say(QUIET_S / 10, **(motion if turn % 2 else {})) for turn in range(12)][-1]


def test_one_that_repeats_itself_is_asked_as_often_as_ever(unit):
    same = {"gyro_rps": GYRO_ZERO, "accel_mps2": (0.0, 0.0, 9.81)}
    unit.say(**same)
    assert not unit.say(**same)


def test_a_sample_that_came_twice_does_not_begin_the_wait_anew():
    unit = Unit()
    unit.say(QUIET_S / 2)
    unit.say(0.02, gyro_rps=GYRO_ZERO, accel_mps2=(0.0, 0.0, 9.81))
    unit.say(QUIET_S / 2)
    assert unit.say(0.05)


def test_a_turn_at_an_even_rate_becomes_quiet_and_its_end_is_seen_at_once(unit):
    unit.say(QUIET_S + 0.1, turn_rps=1.0)
    assert unit.say(turn_rps=1.0)
    assert not unit.say(turn_rps=0.9)


def reading(time_s, gyro_rps=(0.01, 0.0, -0.02), accel_mps2=(0.0, 0.0, 9.8), **more):
    return ImuSample(valid=True, time_s=time_s, gyro_rps=gyro_rps, accel_mps2=accel_mps2, **more)


def test_readings_at_rest_are_one_sample_of_their_mean():
    resting, field = RestingSamples(), (20.0, 1.0, -40.0)
    assert resting.take(reading(1.0, mag_ut=field), quiet=True) == []
    assert resting.take(reading(1.04, (0.02, 0.0, -0.02), (0.0, 0.1, 9.8)), quiet=True) == []
    (sample,) = resting.take(reading(1.08, (0.03, 0.0, -0.02), (0.0, 0.2, 9.8)), quiet=True)
    assert (sample.time_s, sample.span_s) == (1.08, pytest.approx(0.08))
    assert sample.gyro_rps == pytest.approx((0.02, 0.0, -0.02))
    assert sample.accel_mps2 == pytest.approx((0.0, 0.1, 9.8))
    assert sample.mag_ut == field


@pytest.mark.parametrize(
    ("newest", "quiet"),
    [
        (reading(1.04, (0.01, 0.0, 0.4)), False),
        (reading(1.04, (0.01, 0.0, SLOW_RPS)), True),
        (ImuSample(valid=False, time_s=1.04, reason="i2c"), False),
    ],
    ids=["moves", "turns evenly", "not measured"],
)
def test_a_motion_is_a_sample_at_once_and_no_reading_before_it_is_lost(newest, quiet):
    resting, first = RestingSamples(), reading(1.0)
    assert resting.take(first, quiet=True) == []
    assert resting.take(newest, quiet=quiet) == [first, newest]
    assert resting.take(newest, quiet=quiet) == [newest]


def test_readings_with_a_gap_between_them_are_not_one_sample():
    resting, first, later = RestingSamples(), reading(1.0), reading(1.0 + 2 * LATE_S)
    assert resting.take(first, quiet=True) == []
    assert resting.take(later, quiet=True) == [first]
    assert resting.take(reading(later.time_s + 0.04), quiet=True) == []
    assert resting.take(reading(later.time_s + 0.08), quiet=True)[0].span_s == pytest.approx(0.08)


class CompassBus:
    """A bus with a compass that has always measured; `asked` counts its measurements."""

    asked = 0

    def write_byte_data(self, _address, _register, value):
        self.asked += value == registers.SINGLE

    def read_i2c_block_data(self, _address, _register, length):
        return [1, *bytes(length - 1)]


@pytest.mark.parametrize(("rests", "measurements"), [(False, 25), (True, 9)])
def test_the_compass_of_a_unit_at_rest_measures_once_for_each_sample(rests, measurements):
    bus = CompassBus()
    compass = Compass(bus, 25.0, lambda _seconds: None)
    compass.rest(rests=rests)
    fields = [compass.poll(tick / QUIET_HZ) for tick in range(25)]
    assert bus.asked == measurements
    assert len([field for field in fields if field is not None]) == measurements - 1
