"""The orientation that an inertial unit computes itself."""

from math import asin, atan2, cos, degrees, hypot, sin, sqrt

from lbr.messages.units import Quaternion, Vector
from lbr.simulation.measured import ImuReading

_SETTLE_S = 0.5
"""The time in which gravity and field overrule the sum of the gyro."""


class Orientation:
    """From x north, y west and z up to the unit's axes: gyro for the moment, gravity and field in the long run."""

    def __init__(self) -> None:
        self.quaternion: Quaternion | None = None
        self._at = 0.0

    def follow(self, reading: ImuReading, now: float) -> None:
        """Process another reading."""
        reference, before = facing(reading.accel_mps2, reading.mag_ut), self.quaternion
        dt_s, self._at = now - self._at, now
        if before is None or not 0.0 <= dt_s < _SETTLE_S:
            self.quaternion = reference
            return
        self.quaternion = _blended(_turned(before, reading.gyro_rps, dt_s), reference, dt_s / _SETTLE_S)


def facing(accel_mps2: Vector, mag_ut: Vector) -> Quaternion:
    """Return the orientation with this direction of gravity and of the earth's field."""
    x, y, z = accel_mps2
    roll, pitch = atan2(y, z), atan2(-x, hypot(y, z))
    mx, my, mz = mag_ut
    ahead = mx * cos(pitch) + (my * sin(roll) + mz * cos(roll)) * sin(pitch)
    aside = my * cos(roll) - mz * sin(roll)
    return from_angles(roll, pitch, atan2(-aside, ahead))


def from_angles(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the orientation turned by yaw, then pitch, then roll, in radians."""
    cr, sr, cp, sp = cos(roll / 2), sin(roll / 2), cos(pitch / 2), sin(pitch / 2)
    cy, sy = cos(yaw / 2), sin(yaw / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def angles_deg(quaternion: Quaternion) -> Vector:
    """Return roll, pitch and yaw in degrees."""
    w, x, y, z = quaternion
    roll = atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return (degrees(roll), degrees(pitch), degrees(yaw))


def _turned(quaternion: Quaternion, gyro_rps: Vector, dt_s: float) -> Quaternion:
    w, x, y, z = quaternion
    p, q, r = (rate * dt_s / 2 for rate in gyro_rps)
    return (w - x * p - y * q - z * r, x + w * p + y * r - z * q, y + w * q + z * p - x * r, z + w * r + x * q - y * p)


def _blended(first: Quaternion, second: Quaternion, share: float) -> Quaternion:
    same = 1.0 if sum(a * b for a, b in zip(first, second, strict=True)) >= 0 else -1.0
    w, x, y, z = (a + (same * b - a) * share for a, b in zip(first, second, strict=True))
    length = sqrt(w * w + x * x + y * y + z * z) or 1.0
    return (w / length, x / length, y / length, z / length)
