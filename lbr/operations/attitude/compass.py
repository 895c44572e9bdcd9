"""The magnetometer's calibration as stored in rows, and the checks of a field against the Earth's."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

from lbr.messages.units import Vector
from lbr.operations.attitude.geometry import IDENTITY, Matrix, cross, dot, minus, norm, times
from lbr.operations.attitude.settings import AttitudeSettings

OFFSETS = ("mag_offset_x_ut", "mag_offset_y_ut", "mag_offset_z_ut")
MATRIX = tuple(tuple(f"mag_matrix_{row}{column}" for column in range(3)) for row in range(3))
HORIZONTAL = "mag_horizontal_ut"
SENSOR_LIMIT_UT = 3000.0
"""A limit above that of every supported sensor, along all of its axes together (AK8975: 1229 each)."""

_LEAST_DETERMINANT, _MOST_DETERMINANT = 0.01, 100.0


@dataclass(frozen=True, slots=True)
class MagCalibration:
    """The calibration of a compass: hard iron adds `offset_ut`, and `matrix` reverses the distortion by soft iron.

    Both are along the sensor's axes. `horizontal_ut` is the field along the ground at calibration. `problem` explains
    why stored values cannot be used.
    """

    offset_ut: Vector = (0.0, 0.0, 0.0)
    matrix: Matrix = IDENTITY
    horizontal_ut: float | None = None
    known: bool = False
    problem: str = ""

    def apply(self, mag_ut: Vector) -> Vector:
        """Return the field without the robot's own iron."""
        return times(self.matrix, minus(mag_ut, self.offset_ut))

    def values(self) -> dict[str, float]:
        """Return the values by the names of their rows."""
        values = dict(zip(OFFSETS, self.offset_ut, strict=True))
        for names, row in zip(MATRIX, self.matrix, strict=True):
            values |= dict(zip(names, row, strict=True))
        return values if self.horizontal_ut is None else values | {HORIZONTAL: self.horizontal_ut}


def from_values(values: Mapping[str, float]) -> MagCalibration:
    """Return the calibration in rows; missing rows count as no iron."""
    if not any(name in values for name in (*OFFSETS, *(name for row in MATRIX for name in row))):
        return MagCalibration()
    x, y, z = (values.get(name, 0.0) for name in OFFSETS)
    rows = [
        tuple(values.get(name, unit) for name, unit in zip(names, units, strict=True))
        for names, units in zip(MATRIX, IDENTITY, strict=True)
    ]
    matrix: Matrix = ((rows[0][0], rows[0][1], rows[0][2]), (rows[1][0], rows[1][1], rows[1][2]), rows[2][:3])  # type: ignore[assignment]
    if not all(map(isfinite, (x, y, z, *matrix[0], *matrix[1], *matrix[2]))):
        return MagCalibration(problem="its calibration rows hold numbers that are not finite")
    if not _LEAST_DETERMINANT < dot(matrix[0], cross(matrix[1], matrix[2])) < _MOST_DETERMINANT:
        return MagCalibration(problem="its calibration rows mag_matrix_00 to mag_matrix_22 are no sensible matrix")
    horizontal = values.get(HORIZONTAL)
    usable = horizontal is not None and isfinite(horizontal) and horizontal > 0.0
    return MagCalibration((x, y, z), matrix, horizontal if usable else None, known=True)


def impossible(mag_ut: Vector) -> str:
    """Return why a measurement is impossible, or an empty string."""
    strength = norm(mag_ut)
    if not isfinite(strength) or strength > SENSOR_LIMIT_UT:
        return f"the magnetometer measures {strength:.0f} uT, which it cannot"
    return "the magnetometer measures exactly nothing; it is broken" if strength == 0.0 else ""


def disturbed(field_ut: Vector, up: Vector, calibration: MagCalibration, settings: AttitudeSettings) -> str:
    """Return why a calibrated field cannot be the Earth's alone, or an empty string."""
    strength = norm(field_ut)
    if not settings.field_min_ut <= strength <= settings.field_max_ut:
        remedy = "" if calibration.known else "; the compass was never calibrated: on wheels `/m/200` does it"
        return (
            f"the magnetic field is disturbed: {strength:.0f} uT, and the Earth's has "
            f"{settings.field_min_ut:g} to {settings.field_max_ut:g}{remedy}"
        )
    expected = calibration.horizontal_ut
    horizontal = norm(cross(field_ut, up))
    if expected is not None and abs(horizontal - expected) > settings.field_tolerance * expected:
        return (
            f"the magnetic field is disturbed: {horizontal:.0f} uT along the ground, and it had {expected:.0f} "
            f"when the compass was calibrated"
        )
    return ""
