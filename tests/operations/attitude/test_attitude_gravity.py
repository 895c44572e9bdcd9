"""How a body leans, by gravity alone."""

from math import cos, radians, sin

import pytest

from lbr.messages.imu import ImuSample
from lbr.operations.attitude.gravity import Gravity
from lbr.operations.attitude.settings import AttitudeSettings, Mounting

G = 9.81


def felt(roll_rad, pitch_rad):
    """Return what is felt at rest."""
    return (-G * sin(pitch_rad), G * cos(pitch_rad) * sin(roll_rad), G * cos(pitch_rad) * cos(roll_rad))


def after(accels, *, since=10.0, gravity=None, **settings):
    """Return a gravity that has felt these, a tenth of a second apart, and when that was."""
    gravity = gravity or Gravity(AttitudeSettings(device="imu", gyro=False, stale_s=0.5, **settings), {}, "attitude")
    now = since
    for accel in accels:
        now = round(now + 0.1, 6)
        gravity.feel(ImuSample(valid=True, time_s=now, accel_mps2=accel), now)
    return gravity, now


@pytest.mark.parametrize(
    ("roll_deg", "pitch_deg"), [(0, 0), (30, 0), (0, 80), (0, -80), (-100, 0), (170, 10), (20, 40)]
)
def test_roll_and_pitch_are_those_of_the_body_and_no_heading_is_claimed(roll_deg, pitch_deg):
    gravity, now = after([felt(radians(roll_deg), radians(pitch_deg))] * 5)
    state = gravity.state(now)
    assert state.valid
    assert (state.roll_rad, state.pitch_rad) == pytest.approx((radians(roll_deg), radians(pitch_deg)), abs=1e-6)
    assert state.heading_deg is None
    assert state.yaw_rad is None
    assert state.turned_deg is None
    assert state.heading_reason
    assert state.code == "not_possible"


def test_a_unit_that_sits_otherwise_is_turned():
    gravity, now = after([(G, 0.0, 0.0)] * 3, mounting=Mounting(axes="-z+y+x"))
    assert gravity.state(now).pitch_rad == pytest.approx(0.0, abs=1e-6)
    assert gravity.up_sensor == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)


def test_a_knock_hardly_counts_and_a_lean_that_stays_does():
    gravity, now = after([felt(0.0, 0.0)] * 5 + [felt(0.0, 1.2)])
    knocked = gravity.state(now).pitch_rad
    assert knocked < 0.7
    gravity, now = after([felt(0.0, 1.2)] * 6, since=now, gravity=gravity)
    assert gravity.state(now).pitch_rad == pytest.approx(1.2, abs=0.05)


def test_what_is_old_missing_or_no_body_at_rest_is_not_known():
    gravity, now = after([])
    assert not gravity.state(now).valid
    assert "no sample" in gravity.state(now).reason
    gravity, now = after([felt(0.0, 0.0)] * 5)
    assert not gravity.state(now + 0.6).valid
    gravity.feel(ImuSample(valid=False, time_s=now + 0.55, reason="it is asleep"), now + 0.55)
    assert gravity.state(now + 0.6).reason == "the inertial unit: it is asleep"
    gravity, now = after([(0.0, 0.0, 40.0)] * 5)
    assert not gravity.state(now).valid
    assert "40.0 m/s²" in gravity.state(now).reason
    gravity, now = after([(0.0, 0.0, float("nan"))] * 5)
    assert not gravity.state(now).valid


def test_a_body_whose_lean_stays_is_still_until_it_leans():
    gravity, now = after([felt(0.02 * (step % 2), 0.1) for step in range(20)])
    assert gravity.state(now).still
    gravity, now = after([felt(0.0, 0.3)], since=now, gravity=gravity)
    assert not gravity.state(now).still
    gravity, now = after([felt(0.0, 0.3)] * 20, since=now, gravity=gravity)
    assert gravity.state(now).still
