"""The readings of the unit, in SI units and by our clock. Pure.

The library's units are g, degrees a second, gauss and milliseconds of the device's own clock. A huge number (PUNK_DBL,
1e300) means not measured.
"""

from collections.abc import Sequence
from math import inf, isfinite, nan

from msgspec import Struct

from lbr.drivers.inertial import RAD_PER_DEG, STANDARD_GRAVITY_MPS2
from lbr.messages.imu import ImuSample
from lbr.messages.units import Vector

UT_PER_GAUSS = 100.0
_NO_NUMBER = 1e290
_DRIFT = 200e-6
_LOST_S = 0.1


class Reading(Struct, frozen=True):
    """One sample as the library delivered it, with its arrival by our clock."""

    accel_g: Sequence[float]
    gyro_dps: Sequence[float]
    mag_g: Sequence[float]
    device_ms: float
    arrived_s: float


class DeviceClock:
    """Dates samples by the device's regular clock: they arrive in bursts, and never before they were measured.

    Quartz clocks differ by some parts in a million, so the offset may drift slowly; a jump starts it anew.
    """

    def __init__(self) -> None:
        self._offset_s = nan
        self._arrived_s = nan
        self._last_s = -inf

    def date_s(self, reading: Reading) -> float:
        """Return when a sample was measured, by our clock: later than the one before, and not after its arrival."""
        seen_s = reading.arrived_s - reading.device_ms / 1000.0
        if not abs(seen_s - self._offset_s) <= _LOST_S:  # this way round, the first one too
            self._offset_s = seen_s
        else:
            creep_s = _DRIFT * max(0.0, reading.arrived_s - self._arrived_s)
            self._offset_s = min(seen_s, self._offset_s + creep_s)
        self._arrived_s = reading.arrived_s
        dated_s = reading.device_ms / 1000.0 + self._offset_s
        self._last_s = dated_s if dated_s > self._last_s else min(self._last_s + 1e-6, reading.arrived_s)
        return self._last_s


def sample(reading: Reading, time_s: float, gravity_sign: int) -> ImuSample:
    """Return a reading as a sample; without acceleration or turn rate it is invalid, with the reason."""
    accel = scaled(reading.accel_g, gravity_sign * STANDARD_GRAVITY_MPS2)
    gyro = scaled(reading.gyro_dps, RAD_PER_DEG)
    if accel is None or gyro is None:
        missing = "acceleration" if accel is None else "turn rate"
        return ImuSample(valid=False, time_s=time_s, reason=f"the unit measured no {missing}")
    return ImuSample(
        valid=True, time_s=time_s, gyro_rps=gyro, accel_mps2=accel, mag_ut=scaled(reading.mag_g, UT_PER_GAUSS)
    )


def scaled(values: Sequence[float], unit: float) -> Vector | None:
    """Return three numbers in another unit; None if one of them was not measured."""
    if len(values) != 3 or not all(isfinite(value) and abs(value) < _NO_NUMBER for value in values):
        return None
    x, y, z = values
    return (x * unit, y * unit, z * unit)
