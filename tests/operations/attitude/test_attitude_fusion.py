"""Orientation, heading and angle turned, against a made-up inertial unit whose truth is known."""

from math import degrees, inf, nan, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from lbr.drivers.inertial import AT_REST, RestingSamples
from lbr.messages.imu import ImuSample
from lbr.operations.attitude.fusion import LEARNING, NO_FIELD, Fusion
from lbr.operations.attitude.settings import AttitudeSettings, Mounting
from tests.operations.attitude.imu_bench import MadeUpImu, about, apart_deg, euler_deg, feed


def fusion(values=None, **more):
    return Fusion(AttitudeSettings(device="imu", **more), values or {}, "epoch")


def at_rest(imu, seconds=2.0, **more):
    under_test = fusion(**more)
    return under_test, feed(under_test, imu.run(seconds))


@pytest.mark.parametrize(("yaw_deg", "heading"), [(90.0, 0.0), (0.0, 90.0), (-90.0, 180.0), (180.0, 270.0)])
def test_north_is_zero_and_east_is_ninety(yaw_deg, heading):
    _, state = at_rest(MadeUpImu(yaw_deg=yaw_deg))
    assert state.valid
    assert state.magnetic
    assert apart_deg(state.heading_deg, heading) < 1.0
    assert apart_deg(degrees(state.yaw_rad), yaw_deg) < 1.0


def test_a_declination_to_the_east_is_added_to_the_heading():
    _, state = at_rest(MadeUpImu(yaw_deg=90.0), declination_deg=13.9)
    assert apart_deg(state.heading_deg, 13.9) < 1.0


def test_a_tilted_body_keeps_its_heading_and_tells_its_tilt():
    _, state = at_rest(MadeUpImu(yaw_deg=30.0, roll_deg=12.0, pitch_deg=-9.0))
    assert apart_deg(state.heading_deg, 60.0) < 1.5
    assert euler_deg(state) == pytest.approx((12.0, -9.0), abs=0.5)


@pytest.mark.parametrize(
    ("mounting", "matrix"),
    [
        (Mounting(yaw_deg=-90.0), about(2, -1.5707963267948966)),
        (Mounting(axes="+y-x+z"), about(2, -1.5707963267948966)),
        (Mounting(roll_deg=180.0), about(0, 3.141592653589793)),
        (Mounting(axes="+x-y-z"), about(0, 3.141592653589793)),
    ],
)
def test_a_sensor_mounted_otherwise_says_the_same_of_the_body(mounting, matrix):
    imu = MadeUpImu(yaw_deg=30.0, pitch_deg=5.0, sensor_in_body=matrix)
    under_test, state = at_rest(imu, mounting=mounting)
    assert apart_deg(state.heading_deg, 60.0) < 1.5
    assert euler_deg(state)[1] == pytest.approx(5.0, abs=0.5)
    assert feed(under_test, imu.run(1.0, 90.0)).turned_deg == pytest.approx(90.0, abs=1.0)


def test_the_zero_of_the_gyro_is_learnt_at_rest_before_anything_is_valid():
    imu = MadeUpImu(bias_dps=(3.0, -8.0, 12.0))
    under_test = fusion()
    early = feed(under_test, imu.run(0.3))
    assert not early.valid
    assert early.reason == LEARNING
    state = feed(under_test, imu.run(2.0))
    assert state.valid
    assert state.still
    assert [degrees(axis) for axis in state.gyro_bias_rps] == pytest.approx([3.0, -8.0, 12.0], abs=0.1)


def test_means_of_readings_turn_the_body_as_far_as_each_reading_does():
    imu = MadeUpImu(bias_dps=(0.3, -0.2, 0.4), rate_hz=25.0)
    readings, resting = [*imu.run(4.08), *imu.run(5.04, 4.0)], RestingSamples()
    samples = [sample for reading in readings for sample in resting.take(reading, quiet=True)]
    assert len(samples) == len(readings) // AT_REST
    by_each, by_mean = feed(fusion(), readings), feed(fusion(), samples)
    assert by_each.epoch == by_mean.epoch
    assert by_mean.turned_deg == pytest.approx(by_each.turned_deg, abs=0.1)
    assert by_mean.turned_deg == pytest.approx(20.16, abs=0.5)


def test_a_mean_sample_that_was_lost_is_a_gap():
    readings, resting = MadeUpImu(rate_hz=25.0).run(4.0), RestingSamples()
    samples = [sample for reading in readings for sample in resting.take(reading, quiet=True)]
    under_test = fusion()
    epoch = feed(under_test, samples[:-4]).epoch
    assert feed(under_test, samples[-2:]).epoch != epoch


def test_nothing_is_learnt_while_the_body_turns():
    imu = MadeUpImu()
    under_test = fusion()
    state = feed(under_test, imu.run(5.0, 40.0))
    assert not state.valid
    _, state = at_rest(imu)
    assert state.valid


def test_a_slow_even_turn_is_not_taken_for_the_zero():
    imu = MadeUpImu()
    under_test, _ = at_rest(imu)
    state = feed(under_test, imu.run(20.0, 1.2))
    assert degrees(state.gyro_bias_rps[2]) == pytest.approx(0.0, abs=0.1)


def test_a_zero_learnt_wrongly_is_found_out_by_the_compass():
    imu = MadeUpImu()
    under_test = fusion()
    feed(under_test, imu.run(2.0, 8.0, mag=False))
    state = feed(under_test, imu.run(6.0))
    assert degrees(state.gyro_bias_rps[2]) == pytest.approx(0.0, abs=0.1)


def test_the_angle_turned_is_exact_signed_and_goes_on_past_a_turn():
    imu = MadeUpImu(bias_dps=(1.0, -2.0, 3.0))
    under_test, before = at_rest(imu)
    state = feed(under_test, imu.run(10.0, 75.0))
    assert state.turned_deg - before.turned_deg == pytest.approx(750.0, abs=1.0)
    assert state.turn_rate_dps == pytest.approx(75.0, abs=1.0)
    assert not state.still
    back = feed(under_test, imu.run(10.0, -75.0))
    assert back.turned_deg == pytest.approx(before.turned_deg, abs=1.5)
    assert back.epoch == before.epoch


def test_the_angle_turned_ignores_the_tilt_of_the_sensor():
    imu = MadeUpImu(roll_deg=10.0, pitch_deg=10.0)
    under_test, before = at_rest(imu)
    state = feed(under_test, imu.run(4.0, 90.0))
    assert state.turned_deg - before.turned_deg == pytest.approx(360.0, abs=2.0)


def test_the_compass_never_makes_the_angle_turned_jump():
    imu = MadeUpImu(yaw_deg=10.0)
    under_test, before = at_rest(imu, compass_retrust_s=1.0)
    imu.field_enu_ut = about(2, 1.0) @ imu.field_enu_ut
    worst = 0.0
    for sample in imu.run(8.0):
        under_test.feel(sample, sample.time_s)
        worst = max(worst, abs(under_test.state(sample.time_s).turned_deg - before.turned_deg))
    assert worst < 0.5
    assert apart_deg(under_test.state(imu.time_s).heading_deg, before.heading_deg) > 30.0


def test_another_calibration_takes_effect_at_once_and_the_turn_goes_on():
    imu = MadeUpImu(yaw_deg=90.0, hard_iron_ut=(15.0, -10.0, 5.0))
    under_test, before = at_rest(imu)
    assert not before.calibrated
    under_test.calibrate({"mag_offset_x_ut": 15.0, "mag_offset_y_ut": -10.0, "mag_offset_z_ut": 5.0})
    state = feed(under_test, imu.run(0.1))
    assert state.calibrated
    assert apart_deg(state.heading_deg, 0.0) < 2.5
    assert state.turned_deg == pytest.approx(before.turned_deg, abs=0.2)
    assert state.epoch == before.epoch


def test_without_a_magnetometer_the_turn_is_known_and_the_heading_is_not():
    imu = MadeUpImu()
    under_test = fusion()
    state = feed(under_test, imu.run(2.0, mag=False))
    assert state.valid
    assert state.turned_deg is not None
    assert state.orientation is not None
    assert (state.heading_deg, state.yaw_rad, state.heading_reason) == (None, None, NO_FIELD)
    assert (state.reason, state.code) == ("", "not_possible")


def test_a_disturbed_field_is_bridged_by_gyro_then_the_heading_is_unknown():
    imu = MadeUpImu(yaw_deg=90.0)
    under_test, _ = at_rest(imu)
    imu.hard_iron_ut = (120.0, 0.0, 0.0)
    bridged = feed(under_test, imu.run(0.5, 40.0))
    assert apart_deg(bridged.heading_deg, imu.heading_deg) < 2.0
    assert not bridged.magnetic
    lost = feed(under_test, imu.run(1.0))
    assert lost.valid
    assert lost.heading_deg is None
    assert "disturbed" in lost.heading_reason
    assert (bridged.code, lost.code) == ("", "stale_sensor")
    imu.hard_iron_ut = (0.0, 0.0, 0.0)
    assert apart_deg(feed(under_test, imu.run(0.5)).heading_deg, imu.heading_deg) < 2.0


def test_a_compass_that_was_never_calibrated_says_what_calibrates_it(wording):
    imu = MadeUpImu()
    imu.hard_iron_ut = (0.0, 300.0, 0.0)
    under_test = fusion()
    wording(feed(under_test, imu.run(2.0)).heading_reason)


def test_a_field_unlike_the_calibrated_one_is_disturbed():
    imu = MadeUpImu()
    under_test, _ = at_rest(imu, values={"mag_offset_x_ut": 0.0, "mag_horizontal_ut": 19.0})
    imu.hard_iron_ut = (0.0, 12.0, 0.0)
    assert "along the ground" in feed(under_test, imu.run(2.0)).heading_reason


def test_a_compass_that_contradicts_the_gyro_is_believed_after_a_while():
    imu = MadeUpImu(yaw_deg=90.0)
    under_test, _ = at_rest(imu)
    imu.field_enu_ut = about(2, 1.0) @ imu.field_enu_ut
    state = feed(under_test, imu.run(2.0))
    assert state.heading_deg is None
    assert "contradicts" in state.heading_reason
    assert apart_deg(feed(under_test, imu.run(11.0)).heading_deg, degrees(1.0)) < 3.0


def test_silence_is_invalid_and_the_turn_begins_anew():
    imu = MadeUpImu()
    under_test, before = at_rest(imu)
    silent = under_test.state(imu.time_s + 0.25)
    assert not silent.valid
    assert "no sample" in silent.reason
    assert silent.code == "stale_sensor"
    assert silent.turned_deg is silent.heading_deg is None
    imu.time_s += 0.3
    again = feed(under_test, imu.run(0.05))
    assert not again.valid
    assert "missing" in again.reason
    state = feed(under_test, imu.run(0.2))
    assert state.valid
    assert state.epoch != before.epoch
    assert abs(state.turned_deg) < 0.5


def test_a_few_missing_samples_change_nothing():
    imu = MadeUpImu()
    under_test, before = at_rest(imu)
    feed(under_test, imu.run(0.5, 60.0))
    for number, sample in enumerate(imu.run(1.0, 60.0)):
        if number % 8 == 0:
            under_test.feel(sample, sample.time_s)
    state = feed(under_test, imu.run(0.5, 60.0))
    assert state.epoch == before.epoch
    assert state.turned_deg == pytest.approx(imu.turned_deg, abs=0.7)


def test_what_the_driver_calls_invalid_is_bridged_shortly_then_its_reason_is_told():
    imu = MadeUpImu()
    under_test, before = at_rest(imu)
    under_test.feel(ImuSample(valid=False, time_s=imu.time_s + 0.01, reason="the i2c bus hangs"), imu.time_s + 0.01)
    assert under_test.state(imu.time_s + 0.02).valid
    late = under_test.state(imu.time_s + 0.15)
    assert (late.valid, late.reason) == (False, "the inertial unit: the i2c bus hangs")
    assert under_test.epoch == before.epoch


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"gyro_rps": (0.0, nan, 0.0)}, "not a number"),
        ({"accel_mps2": (inf, 0.0, 0.0)}, "not a number"),
        ({"mag_ut": (5000.0, 0.0, 0.0)}, "which it cannot"),
        ({"mag_ut": (0.0, 0.0, 0.0)}, "broken"),
    ],
)
def test_a_sample_that_cannot_be_is_invalid_at_once_and_ends_the_count(change, reason):
    imu = MadeUpImu()
    under_test, before = at_rest(imu)
    bad = replace(imu.sample(), **change)
    under_test.feel(bad, bad.time_s)
    state = under_test.state(imu.time_s)
    assert not state.valid
    assert reason in state.reason
    assert state.epoch != before.epoch
    assert feed(under_test, imu.run(0.5)).valid


def test_a_turn_faster_than_any_is_invalid():
    imu = MadeUpImu()
    under_test, _ = at_rest(imu)
    rates = (90.0 * step for step in range(1, 8))
    state = feed(under_test, (imu.sample(rate) for rate in rates))
    assert not state.valid
    assert "more than 500" in state.reason


@pytest.mark.parametrize("accel", [(0.0, 0.0, 0.0), (0.0, 0.0, 30.0)])
def test_an_accelerometer_far_from_gravity_for_a_while_is_invalid(accel):
    imu = MadeUpImu()
    under_test, _ = at_rest(imu)
    knock = replace(imu.sample(), accel_mps2=(0.0, 0.0, 14.0))
    under_test.feel(knock, knock.time_s)
    assert under_test.state(imu.time_s).valid
    state = feed(under_test, (replace(s, accel_mps2=accel) for s in imu.run(0.3)))
    assert not state.valid
    assert "accelerometer" in state.reason


def jumped(sample, by_rps=4.0):
    x, y, z = sample.gyro_rps
    return replace(sample, gyro_rps=(x, y, z + by_rps))


def test_a_sample_that_jumps_is_left_out():
    imu = MadeUpImu()
    under_test, before = at_rest(imu)
    for number, sample in enumerate(imu.run(2.0, 45.0)):
        felt = jumped(sample, 4.0 if number % 3 else -4.0) if number % 10 == 0 else sample
        under_test.feel(felt, sample.time_s)
    state = under_test.state(imu.time_s)
    assert state.turned_deg == pytest.approx(90.0, abs=1.0)
    assert state.epoch == before.epoch


@pytest.mark.parametrize("by_rps", [4.0, -4.0])
def test_a_gyro_that_jumps_for_good_is_invalid_until_it_is_near_its_old_rate_or_rest(by_rps):
    imu = MadeUpImu()
    under_test, before = at_rest(imu)
    state = feed(under_test, (jumped(sample, by_rps) for sample in imu.run(3.0)))
    assert not state.valid
    assert "jumped" in state.reason
    state = feed(under_test, imu.run(0.5))
    assert state.valid
    assert state.epoch != before.epoch


def test_a_gyro_that_ends_a_jump_at_rest_is_believed():
    imu = MadeUpImu()
    under_test, _ = at_rest(imu)
    for rate in range(0, 200, 20):
        feed(under_test, imu.run(0.05, float(rate)))
    assert feed(under_test, imu.run(0.05)).valid
    assert not feed(under_test, imu.run(0.15, -300.0)).valid
    assert feed(under_test, imu.run(0.5)).valid


def test_a_frozen_gyro_is_invalid():
    imu = MadeUpImu()
    under_test, _ = at_rest(imu)
    stuck = imu.sample()
    state = feed(under_test, (replace(stuck, time_s=stuck.time_s + 0.01 * n) for n in range(70)))
    assert not state.valid
    assert "frozen" in state.reason


def test_a_sample_that_comes_twice_or_late_counts_once():
    imu = MadeUpImu()
    under_test, _ = at_rest(imu)
    samples = list(imu.run(1.0, 50.0))
    for sample, earlier in zip(samples[1:], samples, strict=False):
        for again in (sample, sample, earlier):
            under_test.feel(again, sample.time_s)
    assert under_test.state(imu.time_s).turned_deg == pytest.approx(imu.turned_deg, abs=1.0)


def test_heading_is_within_a_degree_of_the_truth_while_it_turns():
    iron = about(2, 0.4) @ [[1.15, 0, 0], [0, 0.9, 0], [0, 0, 1]] @ about(2, -0.4)
    imu = MadeUpImu(
        bias_dps=(0.5, -0.7, 0.8), hard_iron_ut=(-34.5, 8.4, 5.0), soft_iron=iron, roll_deg=2.0, mag_every=5
    )
    inverse = [[float(v) for v in row] for row in np.linalg.inv(iron)]
    values = {"mag_offset_x_ut": -34.5, "mag_offset_y_ut": 8.4, "mag_offset_z_ut": 5.0} | {
        f"mag_matrix_{r}{c}": inverse[r][c] for r in range(3) for c in range(3)
    }
    under_test, _ = at_rest(imu, 3.0, values=values)
    errors = []
    for rate in (30.0, 0.0, -60.0, 0.0, 90.0, -5.0):
        for sample in imu.run(3.0, rate):
            under_test.feel(sample, sample.time_s)
            errors.append(apart_deg(under_test.state(sample.time_s).heading_deg, imu.heading_deg))
    assert sqrt(sum(e * e for e in errors) / len(errors)) < 1.0


number = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-10.0, 10.0)
triple = st.tuples(number, number, number)


@given(
    st.lists(
        st.builds(
            ImuSample,
            valid=st.booleans(),
            time_s=st.floats(999.0, 1003.0),
            gyro_rps=st.none() | triple,
            accel_mps2=st.none() | triple,
            mag_ut=st.none() | triple,
        ),
        max_size=12,
    )
)
def test_whatever_comes_a_valid_state_holds_only_numbers_within_bounds(samples):
    imu = MadeUpImu()
    under_test, _ = at_rest(imu, 1.2)
    for sample in samples:
        under_test.feel(sample, 1001.3)
        state = under_test.state(1001.3)
        if state.valid:
            assert state.turned_deg == state.turned_deg
            assert abs(sum(q * q for q in state.orientation) - 1.0) < 1e-3
            assert state.heading_deg is None or 0.0 <= state.heading_deg < 360.0
        else:
            assert state.reason
            assert state.heading_deg is None
