"""The readings of an inertial unit that no body can cause. No I/O and no clock."""

from math import degrees, isfinite, radians

from lbr.messages.imu import ImuSample
from lbr.messages.units import Vector
from lbr.operations.attitude.compass import impossible
from lbr.operations.attitude.geometry import norm
from lbr.operations.attitude.settings import AttitudeSettings

G_MPS2 = 9.80665

_REST = (0.0, 0.0, 0.0)
_SMOOTH_S = 0.1


class Suspicion:
    """Compares each sample with the last good one, and returns a sentence about an error, or an empty string."""

    def __init__(self, settings: AttitudeSettings) -> None:
        self._settings = settings
        self._jumped = False
        self._same_since_s = 0.0
        self._accel_mps2 = G_MPS2

    def jump(self, last: ImuSample | None, gyro: Vector, gap_s: float) -> str:
        """Return an error if no body accelerates so; after a jump the gyro is trusted again near its last rate, or at
        rest."""
        self._jumped = self._jumps(last, gyro, gap_s)
        return (
            f"the gyro jumped by more than {self._settings.gyro_jump_dps:g} degrees per second" if self._jumped else ""
        )

    def impossible(self, last: ImuSample | None, sample: ImuSample, gyro: Vector, accel: Vector) -> str:
        """Return why a sample is impossible, or an empty string."""
        s = self._settings
        fastest_dps = degrees(max(abs(gyro[0]), abs(gyro[1]), abs(gyro[2])))
        strength = norm(accel)
        if not (isfinite(fastest_dps) and isfinite(gyro[0] + gyro[1] + gyro[2]) and isfinite(strength)):
            return "the inertial unit measures a value that is not a number"
        if fastest_dps > s.gyro_limit_dps:
            return f"the gyro reads {fastest_dps:.0f} degrees per second, more than {s.gyro_limit_dps:g}"
        if last is None or gyro != last.gyro_rps or accel != last.accel_mps2:
            self._same_since_s = sample.time_s
        elif sample.time_s - self._same_since_s >= s.frozen_s:
            return f"gyro and accelerometer say the very same for {s.frozen_s:g} s; they are frozen"
        dt = s.gap_s if last is None else sample.time_s - last.time_s
        self._accel_mps2 += (strength - self._accel_mps2) * max(0.0, min(1.0, dt / _SMOOTH_S))
        if not s.accel_min_mps2 <= self._accel_mps2 <= s.accel_max_mps2:
            return f"the accelerometer reads {self._accel_mps2:.1f} m/s2, and at rest it is {G_MPS2:.1f}"
        return "" if sample.mag_ut is None else impossible(sample.mag_ut)

    def _jumps(self, last: ImuSample | None, gyro: Vector, gap_s: float) -> bool:
        limit = radians(self._settings.gyro_jump_dps)
        if last is None or last.gyro_rps is None or not (self._jumped or 0.0 <= gap_s <= self._settings.gap_s):
            return False
        if _within(gyro, last.gyro_rps, limit):
            return False
        return not (self._jumped and _within(gyro, _REST, limit))


def _within(a: Vector, b: Vector, limit: float) -> bool:
    """Return whether no component differs by more; NaN is left to other checks."""
    return not (abs(a[0] - b[0]) > limit or abs(a[1] - b[1]) > limit or abs(a[2] - b[2]) > limit)
