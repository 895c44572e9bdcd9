"""Fitting iron: exact on clean samples, near on noisy ones, and a sentence for what cannot be fitted."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.operations.attitude.compass import OFFSETS, MagCalibration, from_values
from lbr.operations.attitude.fit import FitError, fit
from lbr.operations.attitude.settings import AttitudeSettings

LIMITS = AttitudeSettings(device="imu")
UP = (0.0, 0.0, 9.8)


def ring(count=120, turn=1.0, radius=20.0, *, iron=None, offset=(0.0, 0.0, 0.0), noise=0.0, seed=1):
    angles = np.arange(count) / count * 2 * pi * turn
    true = np.stack((radius * np.cos(angles), radius * np.sin(angles), np.full(count, -40.0)), axis=1)
    noisy = true @ (np.eye(3) if iron is None else np.array(iron)).T + offset
    return noisy + np.random.default_rng(seed).normal(0.0, noise, (count, 3)) if noise else noisy


def fitted(mags, ups=None, limits=LIMITS):
    return fit([tuple(m) for m in mags.tolist()], ups or [UP] * len(mags), limits)


def refusal(mags, limits=LIMITS):
    with pytest.raises(FitError) as caught:
        fitted(mags, limits=limits)
    return str(caught.value)


@given(
    x=st.floats(-200, 200),
    y=st.floats(-200, 200),
    ratio=st.floats(0.5, 1.0),
    angle=st.floats(0, pi),
    radius=st.floats(10, 35),
)
def test_a_ring_distorted_by_iron_becomes_a_circle_about_zero(x, y, ratio, angle, radius):
    c, s = cos(angle), sin(angle)
    turn = np.array(((c, -s), (s, c)))
    iron = np.eye(3)
    iron[:2, :2] = turn @ np.diag((1.0, ratio)) @ turn.T
    found = fitted(ring(radius=radius, iron=iron, offset=(x, y, 3.0))).calibration
    assert found.offset_ut[:2] == pytest.approx((x, y), abs=0.01)
    assert found.offset_ut[2] == pytest.approx(0.0, abs=1e-6)
    mended = np.array(found.matrix) @ iron
    assert mended[:2, :2] / mended[0, 0] == pytest.approx(np.eye(2), abs=1e-3)
    assert found.horizontal_ut == pytest.approx(radius * ratio**0.5, rel=1e-3)


def test_a_sensor_that_stands_upright_is_fitted_along_the_ground():
    turned = ring(offset=(5.0, -7.0, 0.0))[:, [2, 0, 1]]
    found = fitted(turned, [(9.8, 0.0, 0.0)] * len(turned)).calibration
    assert found.offset_ut == pytest.approx((0.0, 5.0, -7.0), abs=0.01)


def test_all_directions_give_all_three_axes():
    directions = np.random.default_rng(3).normal(size=(400, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    iron = np.array(((1.1, 0.05, 0.0), (0.05, 0.9, -0.03), (0.0, -0.03, 1.0)))
    found = fitted((50.0 * directions) @ iron.T + (10.0, -20.0, 30.0), [tuple(d) for d in directions.tolist()])
    assert not found.flat
    assert found.calibration.offset_ut == pytest.approx((10.0, -20.0, 30.0), abs=0.01)
    mended = np.array(found.calibration.matrix) @ iron
    assert mended / mended[0, 0] == pytest.approx(np.eye(3), abs=1e-3)


def test_noise_and_a_few_outliers_do_little_harm():
    mags = ring(300, offset=(12.0, -9.0, 4.0), noise=0.4)
    mags[::40] += 15.0
    found = fitted(mags)
    assert found.calibration.offset_ut[:2] == pytest.approx((12.0, -9.0), abs=0.3)
    assert found.residual < 0.04


@pytest.mark.parametrize(
    ("mags", "reason"),
    [
        (ring(30), "too few"),
        (ring(120, turn=0.5), "% of a full turn"),
        (ring(120, radius=0.1), "hardly changed"),
        (ring(120, iron=np.diag((1.0, 0.01, 1.0))), "along a line"),
        (ring(120, iron=np.diag((1.0, 0.2, 1.0))), "distorted"),
        (ring(120, radius=200.0), "not the Earth's"),
        (ring(200, noise=4.0), "do not fit"),
        (np.full((100, 3), np.nan), "no"),
    ],
)
def test_what_is_no_calibration_is_refused_with_a_sentence(mags, reason):
    assert reason in refusal(mags)


def test_noise_alone_is_refused_with_a_sentence():
    for seed in range(20):
        refusal(np.random.default_rng(seed).normal(0.0, 20.0, (100, 3)))


@given(st.lists(st.tuples(*[st.floats(-1e4, 1e4)] * 3), min_size=50, max_size=80))
def test_whatever_the_samples_are_there_is_a_fit_or_a_sentence(mags):
    try:
        found = fit(mags, [UP] * len(mags), LIMITS)
    except FitError as err:
        found = None
        assert str(err)  # noqa: PT017 - a fit is as good as a refusal
    assert found is None or from_values(found.calibration.values()) == found.calibration


def test_rows_bring_back_what_was_kept_and_nonsense_is_named():
    kept = MagCalibration((1.0, 2.0, 3.0), ((1.0, 0.1, 0.0), (0.1, 0.9, 0.0), (0.0, 0.0, 1.0)), 20.0, known=True)
    assert from_values(kept.values()) == kept
    assert from_values({}) == MagCalibration()
    assert "no sensible matrix" in from_values(kept.values() | {"mag_matrix_11": 0.0}).problem
    assert "numbers" in from_values({OFFSETS[0]: float("nan")}).problem


def test_a_partial_calibration_is_one_without_soft_iron():
    found = from_values({"mag_offset_x_ut": -34.5, "mag_offset_y_ut": 8.4})
    assert found.known
    assert found.apply((0.0, 10.0, 5.0)) == (34.5, 10.0 - 8.4, 5.0)
