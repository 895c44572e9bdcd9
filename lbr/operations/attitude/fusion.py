"""Orientation and heading of the body from samples of an inertial unit. No I/O and no clock of its own.

The same samples give the same states. Fusion's filter (imufusion) computes the orientation from gyro, accelerometer and
compass. The angle turned is the gyro's alone, so that the compass cannot make it jump.
"""

from collections.abc import Mapping
from math import degrees, radians
from typing import Any

import imufusion

from lbr.messages.attitude import AttitudeState
from lbr.messages.imu import ImuSample
from lbr.messages.units import Quaternion, Vector
from lbr.operations.attitude.compass import disturbed, from_values
from lbr.operations.attitude.geometry import (
    compass_yaw_deg,
    dot,
    heading_deg,
    level,
    minus,
    norm,
    scaled,
    times,
    to_euler,
    turned_about_up,
    wrapped_deg,
)
from lbr.operations.attitude.settings import AttitudeSettings
from lbr.operations.attitude.stillness import Stillness
from lbr.operations.attitude.suspicion import G_MPS2, Suspicion

LEARNING = "the gyro's zero is not known yet; it is learnt in half a second at rest"
NO_FIELD = "the inertial unit measures no magnetic field"
NOT_MEASURED = "the compass has not measured yet"

_DEG = degrees(1.0)
_NOTHING = (0.0, 0.0, 0.0)
_ACCEL_REJECTION_DEG = 15.0
_REJECTION_TIMEOUT_S = 5.0
_LONGEST_PULL_S = 0.5


class Fusion:
    """Processes every sample by `feel`; `state` returns the result.

    `arrived_s` and `now` are of one monotonic clock; the samples' own times may be of another.
    """

    def __init__(self, settings: AttitudeSettings, values: Mapping[str, float], name: str) -> None:
        self._settings = settings
        self._name = name
        self._mount = settings.mounting.matrix()
        self._stillness = Stillness(settings)
        self._ahrs = _filter(settings.gain)
        self._epochs = 1
        self._began = False
        self._last: ImuSample | None = None
        self._arrived_s: float | None = None
        self._missed = ""
        self._suspicion = Suspicion(settings)
        self._trouble = ""
        self._good_since_s: float | None = None
        self._up: Vector = (0.0, 0.0, 1.0)
        self._rate_dps = 0.0
        self._turned_deg = 0.0
        self._field_s: float | None = None
        self._field_measured_s: float | None = None
        self._field_trouble = NOT_MEASURED
        self._contradicts_since_s: float | None = None
        self._aligned = False
        self.calibrate(values)

    @property
    def epoch(self) -> str:
        """Return the name of the current count of `turned_deg`."""
        return f"{self._name}-{self._epochs}"

    @property
    def turned_deg(self) -> float | None:
        """Return the angle that the body has turned in this epoch; None while it is unknown."""
        return self._turned_deg if self._began else None

    @property
    def up_sensor(self) -> Vector:
        """Return the upward vector along the sensor's axes."""
        rows = self._mount
        x, y, z = (dot((rows[0][axis], rows[1][axis], rows[2][axis]), self._up) for axis in range(3))
        return (x, y, z)

    def calibrate(self, values: Mapping[str, float]) -> None:
        """Set another calibration of the compass; the heading may jump, the angle turned continues."""
        self.calibration = from_values(values)
        self._aligned = False
        self._contradicts_since_s, self._field_trouble = None, NOT_MEASURED

    def feel(self, sample: ImuSample, arrived_s: float) -> None:
        """Process a sample; a repeated or late one counts once."""
        if not sample.valid or sample.gyro_rps is None or sample.accel_mps2 is None:
            self._missed = f"the inertial unit: {sample.reason or 'its sample has no gyro or accelerometer'}"
            return
        last = self._last
        if last is not None and 0.0 <= last.time_s - sample.time_s < 1.0:
            return
        missed, gap_s = self._missed, 0.0 if last is None else sample.time_s - sample.span_s - last.time_s
        self._missed = self._suspicion.jump(last, sample.gyro_rps, gap_s)
        if self._missed:
            return
        if not 0.0 <= gap_s <= self._settings.gap_s:
            self._fail(missed or f"samples of {gap_s:.2f} s are missing")
        trouble = self._suspicion.impossible(last, sample, sample.gyro_rps, sample.accel_mps2)
        self._last, self._arrived_s = sample, arrived_s
        if trouble:
            self._fail(trouble)
        else:
            self._take(sample, times(self._mount, sample.gyro_rps), times(self._mount, sample.accel_mps2), gap_s)

    def state(self, now: float) -> AttitudeState:
        """Return the current state."""
        reason = self._reason(now)
        measured_s = self._last.time_s if self._last is not None else 0.0
        known: dict[str, Any] = {"epoch": self.epoch, "measured_s": measured_s, "calibrated": self.calibration.known}
        bias_rps = self._stillness.bias_rps
        if reason:
            return AttitudeState(
                valid=False, reason=reason, code="stale_sensor", heading_reason=reason, gyro_bias_rps=bias_rps, **known
            )
        orientation = turned_about_up(self._quaternion(), -radians(self._settings.declination_deg))
        roll, pitch, yaw = to_euler(orientation)
        unknown = self._heading_unknown(measured_s)
        code = "not_possible" if self.calibration.problem or unknown == NO_FIELD else "stale_sensor"
        return AttitudeState(
            valid=True,
            code=code if unknown else "",
            orientation=orientation,
            roll_rad=roll,
            pitch_rad=pitch,
            yaw_rad=None if unknown else yaw,
            heading_deg=None if unknown else heading_deg(degrees(yaw)),
            heading_reason=unknown,
            turned_deg=self._turned_deg,
            turn_rate_dps=self._rate_dps,
            gyro_bias_rps=bias_rps,
            still=self._stillness.still,
            magnetic=self._aligned and not self._field_trouble and not unknown,
            **known,
        )

    def _reason(self, now: float) -> str:
        """Return why nothing is known, or an empty string."""
        s = self._settings
        if self._arrived_s is None or self._last is None:
            return self._missed or "no sample from the inertial unit yet"
        silent_s = now - self._arrived_s
        if self._missed and silent_s > s.gap_s:
            return self._missed
        if silent_s > s.stale_s + self._last.span_s:
            return f"no sample from the inertial unit for {silent_s:.1f} s"
        if self._trouble:
            return self._trouble
        if self._stillness.bias_rps is None:
            return LEARNING
        return "" if self._began else "the inertial unit's first samples"

    def _fail(self, reason: str) -> None:
        """End the count, because a part of the turn was not measured."""
        self._trouble, self._good_since_s = reason, None
        self._stillness.interrupt()
        if self._began:
            self._epochs += 1
            self._began = False
            self._aligned = False
            self._turned_deg = self._rate_dps = 0.0

    def _take(self, sample: ImuSample, gyro: Vector, accel: Vector, dt: float) -> None:
        self._settle(sample.time_s)
        field = None if sample.mag_ut is None else times(self._mount, self.calibration.apply(sample.mag_ut))
        self._stillness.add(sample.time_s, gyro, accel, field)
        bias = self._stillness.bias_rps
        if self._trouble or bias is None:
            self._up = scaled(accel, 1.0 / (norm(accel) or 1.0))
            return
        rate = minus(gyro, bias)
        if not self._began:
            self._begin(accel, rate)
        elif dt > 0.0:
            self._turn(rate, accel, dt, sample.span_s)
        if field is not None:
            self._look(sample.time_s, field)

    def _settle(self, time_s: float) -> None:
        """End a trouble once samples have been good for a while."""
        if self._good_since_s is None:
            self._good_since_s = time_s
        if self._trouble and time_s - self._good_since_s >= self._settings.recover_s:
            self._trouble = ""

    def _begin(self, accel: Vector, rate: Vector) -> None:
        up = scaled(accel, 1.0 / norm(accel))
        self._ahrs.restart()
        self._ahrs.skip_startup()
        self._ahrs.set_quaternion(level(up))
        self._began, self._up = True, up
        self._rate_dps = -dot(rate, up) * _DEG

    def _turn(self, rate: Vector, accel: Vector, gap_s: float, span_s: float) -> None:
        """Add a rate at the end of a gap, or the mean rate over the span before it."""
        ahrs = self._ahrs
        ahrs.set_sample_period(gap_s + span_s)
        ahrs.update_no_magnetometer(scaled(rate, _DEG), scaled(accel, 1.0 / G_MPS2))
        self._up = tuple(ahrs.get_gravity().tolist())
        before_dps, self._rate_dps = self._rate_dps, -dot(rate, self._up) * _DEG
        self._turned_deg += 0.5 * (before_dps + self._rate_dps) * gap_s + self._rate_dps * span_s

    def _look(self, time_s: float, field: Vector) -> None:
        """Let the compass correct the heading, unless its field is disturbed."""
        since_s = self._field_s
        self._field_measured_s = time_s
        compass = compass_yaw_deg(field, self._up)
        self._field_trouble = disturbed(field, self._up, self.calibration, self._settings)
        if self._field_trouble:
            return
        if compass is None:
            self._field_trouble = "the magnetic field is vertical here"
            return
        self._field_trouble = self._contradiction(time_s, compass)
        if self._field_trouble:
            return
        self._field_s = time_s
        if not self._aligned or since_s is None:
            rested = self._stillness.compass_deg if since_s is None else None
            self._ahrs.set_heading(compass if rested is None else rested)
            self._aligned = True
            return
        self._ahrs.set_sample_period(max(0.0, min(time_s - since_s, _LONGEST_PULL_S)))
        self._ahrs.update(_NOTHING, _NOTHING, field)

    def _contradiction(self, time_s: float, compass_deg: float) -> str:
        """Return how compass and gyro differ, or an empty string; after a while the compass is trusted anyway."""
        if not self._aligned:
            self._contradicts_since_s = None
            return ""
        apart = wrapped_deg(compass_deg - degrees(to_euler(self._quaternion())[2]))
        if abs(apart) <= self._settings.compass_jump_deg:
            self._contradicts_since_s = None
            return ""
        if self._contradicts_since_s is None:
            self._contradicts_since_s = time_s
        if time_s - self._contradicts_since_s > self._settings.compass_retrust_s:
            self._contradicts_since_s, self._aligned = None, False
            return ""
        return f"the compass contradicts the gyro by {abs(apart):.0f} degrees"

    def _heading_unknown(self, time_s: float) -> str:
        """Return why the heading is unknown, or an empty string."""
        hold_s = self._settings.field_hold_s
        if self._aligned and self._field_s is not None and time_s - self._field_s <= hold_s:
            return ""
        if self.calibration.problem:
            return f"the compass: {self.calibration.problem}; on wheels `/m/200` calibrates it"
        if self._field_measured_s is None:
            return NO_FIELD
        if time_s - self._field_measured_s > hold_s:
            return f"{NO_FIELD} for {time_s - self._field_measured_s:.1f} s"
        return self._field_trouble or NOT_MEASURED

    def _quaternion(self) -> Quaternion:
        w, x, y, z = self._ahrs.get_quaternion().tolist()
        return (w, x, y, z)


def _filter(gain: float) -> Any:
    """Create the filter; Any, because it accepts any three numbers, and its stubs only arrays.

    Its settings are set one by one: the constructor of version 1.3 loses `convention`.
    """
    settings = imufusion.AhrsSettings()
    settings.convention = imufusion.CONVENTION_ENU
    settings.gain = gain
    settings.acceleration_rejection = _ACCEL_REJECTION_DEG
    settings.rejection_timeout = _REJECTION_TIMEOUT_S
    return imufusion.Ahrs().set_settings(settings)
