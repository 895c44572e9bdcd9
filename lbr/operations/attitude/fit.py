"""Hard and soft iron of a compass, by least squares: an ellipsoid, or an ellipse for a body that only turned level.

Ellipse: Halir and Flusser 1998, the direct fit whose result is always an ellipse. Pure numpy, no I/O.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbr.errors import LbrError
from lbr.messages.units import Vector
from lbr.operations.attitude.compass import MagCalibration
from lbr.operations.attitude.geometry import Matrix
from lbr.operations.attitude.samples import coverage_of
from lbr.operations.attitude.settings import AttitudeSettings

LEAST_SAMPLES = 50
LEAST_SPREAD_UT = 1.0
FLAT = 0.25
"""The greatest ratio of thickness to length at which a cloud of samples counts as flat."""
MOST_DISTORTED = 4.0
MOST_OUTLIERS = 0.1
HORIZONTAL_UT = (5.0, 60.0)
"""The range of the field along the ground: 0 at the magnetic poles, 42 at most, plus the error of a sensor's scale."""

_OUTLIER_DEVIATIONS = 4.0
_NORMAL = 1.4826

Floats = NDArray[np.floating[Any]]


class FitError(LbrError):
    """The samples give no calibration; the sentence has the reason and the cure."""


@dataclass(frozen=True, slots=True)
class Fit:
    """A calibration and its quality: `residual` is the remaining error, as a fraction of the field (rms).

    `coverage` is the fraction of a full turn in its samples.
    """

    calibration: MagCalibration
    residual: float
    coverage: float
    flat: bool


def fit(mags_ut: Sequence[Vector], ups: Sequence[Vector], settings: AttitudeSettings) -> Fit:
    """Return the calibration from samples along the sensor's axes; raise FitError.

    `ups` has the upward vector of each sample, of any length.
    """
    if len(mags_ut) < LEAST_SAMPLES:
        raise FitError(f"{len(mags_ut)} samples are too few; a calibration needs {LEAST_SAMPLES}")
    mags, up = np.array(mags_ut), np.array(ups)
    if not np.isfinite(mags).all():
        raise FitError("the samples hold numbers that are not finite")
    spread = np.linalg.svd(mags - mags.mean(axis=0), compute_uv=False) / sqrt(len(mags))
    if spread[0] < LEAST_SPREAD_UT:
        raise FitError(
            f"the field hardly changed ({spread[0]:.2f} uT); the robot did not turn, or the compass is frozen"
        )
    if spread[1] < 0.1 * spread[0]:
        raise FitError("the samples lie along a line; turn the robot all the way round")
    flat = bool(spread[2] < FLAT * spread[0])
    solve = _flat if flat else _round
    used = np.ones(len(mags), dtype=bool)
    for _ in range(2):
        calibration = solve(mags[used], up[used])
        errors = _errors(calibration, mags, up, flat=flat)
        limit = _OUTLIER_DEVIATIONS * _NORMAL * float(np.median(np.abs(errors - np.median(errors))))
        used = np.abs(errors - np.median(errors)) <= max(limit, 1e-6)
    return _judged(calibration, mags[used], up[used], 1.0 - float(used.mean()), flat=flat, settings=settings)


def level_part(calibration: MagCalibration | None, mags_ut: Sequence[Vector], ups: Sequence[Vector]) -> Floats:
    """Return the two level components of each sample, corrected by a calibration if there is one."""
    mags, up = np.array(mags_ut, dtype=float).reshape(-1, 3), np.array(ups, dtype=float).reshape(-1, 3)
    if calibration is not None:
        mags = (mags - calibration.offset_ut) @ np.array(calibration.matrix).T
    level: Floats = mags @ _level(up).T
    return level


def _judged(
    calibration: MagCalibration, mags: Floats, up: Floats, outliers: float, *, flat: bool, settings: AttitudeSettings
) -> Fit:
    errors = _errors(calibration, mags, up, flat=flat)
    residual = float(np.sqrt(np.mean(errors**2)))
    level = level_part(calibration, mags.tolist(), up.tolist())
    coverage = coverage_of(np.degrees(np.arctan2(level[:, 1], level[:, 0])).tolist())
    stretch = np.linalg.svd(np.array(calibration.matrix), compute_uv=False)
    total = float(np.mean(np.linalg.norm((mags - calibration.offset_ut) @ np.array(calibration.matrix).T, axis=1)))
    horizontal = float(np.mean(np.linalg.norm(level, axis=1)))
    if coverage < settings.min_coverage:
        raise FitError(
            f"the samples show {coverage:.0%} of a full turn, and {settings.min_coverage:.0%} are needed; ask for more"
        )
    if stretch[0] > MOST_DISTORTED * stretch[-1] or not isfinite(residual):
        raise FitError("the field is distorted more than a calibration can mend; keep iron and magnets off the compass")
    if outliers > MOST_OUTLIERS or residual > settings.max_residual:
        raise FitError(
            f"the samples do not fit ({residual:.1%} of the field are left over, {outliers:.0%} of them are outliers); "
            f"something magnetic moved or is near"
        )
    strength, (least, most) = (horizontal, HORIZONTAL_UT) if flat else (total, _limits(settings))
    if not least <= strength <= most:
        raise FitError(f"a field of {strength:.0f} uT is not the Earth's, which has {least:g} to {most:g}")
    result = MagCalibration(calibration.offset_ut, calibration.matrix, horizontal, known=True)
    return Fit(result, residual, coverage, flat)


def _limits(settings: AttitudeSettings) -> tuple[float, float]:
    return settings.field_min_ut, settings.field_max_ut


def _errors(calibration: MagCalibration, mags: Floats, up: Floats, *, flat: bool) -> Floats:
    """Return the distance of each sample from its ideal circle or sphere, as a fraction of the radius."""
    corrected = (mags - calibration.offset_ut) @ np.array(calibration.matrix).T
    radii = np.linalg.norm(corrected @ _level(up).T if flat else corrected, axis=1)
    errors: Floats = radii / (np.mean(radii) or 1.0) - 1.0
    return errors


def _level(up: Floats) -> Floats:
    """Return two level axes, as rows: along the sensor's x where that is level enough, and to its left."""
    mean = up.mean(axis=0)
    length = float(np.linalg.norm(mean))
    if not isfinite(length) or length == 0.0:
        raise FitError("the accelerometer does not say where up is")
    normal = mean / length
    first = np.eye(3)[int(np.argmin(np.abs(normal)))]
    ahead = first - normal * (first @ normal)
    ahead /= np.linalg.norm(ahead)
    return np.array((ahead, np.cross(normal, ahead)))


def _flat(mags: Floats, up: Floats) -> MagCalibration:
    """Fit an ellipse to the level part, and leave the vertical part unchanged."""
    axes = _level(up)
    points = mags @ axes.T
    middle = points.mean(axis=0)
    scale = float(np.abs(points - middle).max())
    quadratic, linear, constant = _ellipse((points - middle) / scale)
    centre, matrix = _unit(quadratic, linear, constant)
    radius = float(np.linalg.det(matrix)) ** -0.5  # the mean of the two half axes, so that the field keeps its size
    normal = np.cross(axes[0], axes[1])
    whole = axes.T @ (matrix * radius) @ axes + np.outer(normal, normal)
    return _calibration(axes.T @ (centre * scale + middle), whole)


def _round(mags: Floats, _up: Floats) -> MagCalibration:
    """Fit an ellipsoid."""
    middle = mags.mean(axis=0)
    scale = float(np.abs(mags - middle).max())
    x, y, z = ((mags - middle) / scale).T
    terms = np.stack((x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z), axis=1)
    a, b, c, d, e, f, g, h, i = np.linalg.lstsq(terms, np.ones(len(x)), rcond=None)[0]
    centre, matrix = _unit(np.array(((a, d, e), (d, b, f), (e, f, c))), np.array((g, h, i)), -1.0)
    radius = float(np.linalg.det(matrix)) ** (-1.0 / 3.0)
    return _calibration(centre * scale + middle, matrix * radius)


def _ellipse(points: Floats) -> tuple[Floats, Floats, float]:
    """Return the quadratic, half the linear and the constant part of the ellipse nearest to points."""
    x, y = points.T
    quadratic = np.stack((x * x, x * y, y * y), axis=1)
    linear = np.stack((x, y, np.ones_like(x)), axis=1)
    mixed = quadratic.T @ linear
    rest = linear.T @ linear
    try:
        onto = -np.linalg.solve(rest, mixed.T)
    except np.linalg.LinAlgError as err:
        raise FitError("the samples lie along a line; turn the robot all the way round") from err
    reduced = quadratic.T @ quadratic + mixed @ onto
    reduced = np.array((reduced[2] / 2, -reduced[1], reduced[0] / 2))
    vectors = np.real(np.linalg.eig(reduced)[1])
    is_ellipse = 4 * vectors[0] * vectors[2] - vectors[1] ** 2
    a, b, c = vectors[:, int(np.argmax(is_ellipse))]
    d, e, f = onto @ (a, b, c)
    return np.array(((a, b / 2), (b / 2, c))), np.array((d / 2, e / 2)), float(f)


def _unit(quadratic: Floats, linear: Floats, constant: float) -> tuple[Floats, Floats]:
    """Return the centre of x'Qx + 2l'x + c = 0, and the symmetric matrix that makes it a unit circle or sphere."""
    trouble = "the samples lie on no ellipse; something magnetic moved, or they show too little of a turn"
    try:
        centre: Floats = -np.linalg.solve(quadratic, linear)
    except np.linalg.LinAlgError as err:
        raise FitError(trouble) from err
    size = float(centre @ quadratic @ centre) - constant
    if size == 0.0 or not np.isfinite(centre).all():
        raise FitError(trouble)
    values, vectors = np.linalg.eigh(quadratic / size)
    if not (values > 0.0).all():
        raise FitError(trouble)
    matrix: Floats = vectors @ np.diag(np.sqrt(values)) @ vectors.T
    return centre, matrix


def _calibration(offset: Floats, matrix: Floats) -> MagCalibration:
    rows: Matrix = tuple(tuple(float(value) for value in row) for row in matrix)  # type: ignore[assignment]
    x, y, z = (float(value) for value in offset)
    return MagCalibration((x, y, z), rows, None, known=True)
