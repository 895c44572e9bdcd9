"""The lean of a body by an accelerometer alone, for inertial units without a gyro: slow, and right only at rest. No
I/O.

It has the interface of `Fusion`, without heading and turned angle.
"""

from collections.abc import Mapping
from math import asin, atan2, cos, exp, isfinite, radians
from typing import Any

from lbr.messages.attitude import AttitudeState
from lbr.messages.imu import ImuSample
from lbr.messages.units import Vector
from lbr.operations.attitude.compass import from_values
from lbr.operations.attitude.geometry import dot, level, norm, scaled, times
from lbr.operations.attitude.settings import AttitudeSettings

NO_GYRO = "the inertial unit has no gyro and no compass"
SMOOTH_S = 0.15
"""The smoothing time: steps shake the trunk, and shorter motions hardly count."""
STILL = cos(radians(2.0))
"""The lean of a still body stays within two degrees."""
LEAST_MPS2 = 1.0
"""The shortest mean acceleration that still has a direction."""


class Gravity:
    """Processes every sample by `feel`; `state` returns the lean of the body."""

    turned_deg = None

    def __init__(self, settings: AttitudeSettings, values: Mapping[str, float], name: str) -> None:
        self._settings = settings
        self.epoch = f"{name}-1"
        self._mount = settings.mounting.matrix()
        self._accel: Vector = (0.0, 0.0, 0.0)
        self._like: Vector = (0.0, 0.0, 0.0)
        self._still = False
        self._measured_s: float | None = None
        self._arrived_s: float | None = None
        self._began_s: float | None = None
        self._missed = ""
        self.calibrate(values)

    @property
    def up_sensor(self) -> Vector:
        """Return the upward vector along the sensor's axes."""
        rows, up = self._mount, self._up()
        x, y, z = (dot((rows[0][axis], rows[1][axis], rows[2][axis]), up) for axis in range(3))
        return (x, y, z)

    def calibrate(self, values: Mapping[str, float]) -> None:
        """Set a calibration of the compass, which has no use here."""
        self.calibration = from_values(values)

    def feel(self, sample: ImuSample, arrived_s: float) -> None:
        """Process a sample; a repeated or late one counts once."""
        s = self._settings
        if not sample.valid or sample.accel_mps2 is None:
            self._missed = f"the inertial unit: {sample.reason or 'its sample has no accelerometer'}"
            return
        last_s = self._measured_s
        if last_s is not None and 0.0 <= last_s - sample.time_s < 1.0:
            return
        accel = times(self._mount, sample.accel_mps2)
        strength = norm(accel)
        if not (isfinite(strength) and s.accel_min_mps2 <= strength <= s.accel_max_mps2):
            self._missed = f"the accelerometer reads {strength:.1f} m/s², which is not a body at rest"
            return
        gap_s = None if last_s is None else sample.time_s - last_s
        afresh = gap_s is None or not 0.0 < gap_s <= s.stale_s
        share = 1.0 if afresh or gap_s is None else 1.0 - exp(-gap_s / SMOOTH_S)
        x, y, z = (old + share * (new - old) for old, new in zip(self._accel, accel, strict=True))
        self._accel, self._missed = (x, y, z), ""
        up = self._up()
        self._still = dot(up, self._like) >= STILL
        self._like = self._like if self._still else up
        self._measured_s, self._arrived_s = sample.time_s, arrived_s
        self._began_s = sample.time_s if afresh or self._began_s is None else self._began_s

    def state(self, now: float) -> AttitudeState:
        """Return the current state."""
        measured_s, reason = self._measured_s or 0.0, self._reason(now)
        known: dict[str, Any] = {"epoch": self.epoch, "measured_s": measured_s}
        if reason:
            return AttitudeState(valid=False, reason=reason, code="stale_sensor", heading_reason=reason, **known)
        x, y, z = self._up()
        return AttitudeState(
            valid=True,
            orientation=level((x, y, z)),
            roll_rad=atan2(y, z),
            pitch_rad=asin(max(-1.0, min(1.0, -x))),
            code="not_possible",
            heading_reason=NO_GYRO,
            still=self._still,
            **known,
        )

    def _up(self) -> Vector:
        return scaled(self._accel, 1.0 / (norm(self._accel) or 1.0))

    def _reason(self, now: float) -> str:
        """Return why nothing is known, or an empty string."""
        s = self._settings
        if self._arrived_s is None or self._measured_s is None or self._began_s is None:
            return self._missed or "no sample from the inertial unit yet"
        if now - self._arrived_s > s.stale_s:
            return self._missed or f"no sample from the inertial unit for {now - self._arrived_s:.1f} s"
        if self._measured_s - self._began_s < s.recover_s or norm(self._accel) < LEAST_MPS2:
            return self._missed or "the inertial unit's first samples"
        return ""
