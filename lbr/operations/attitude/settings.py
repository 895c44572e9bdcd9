"""Settings of a row of kind `attitude`."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.units import Name
from lbr.operations.attitude.geometry import Matrix, axis_map, rotation

Degrees = Annotated[float, Meta(ge=-360.0, le=360.0, description="degrees")]
Seconds = Annotated[float, Meta(gt=0.0, le=60.0)]
MicroTesla = Annotated[float, Meta(ge=0.0, le=10000.0, description="microtesla")]


class Mounting(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The orientation of the sensor in the body (REP 103: x ahead, y left, z up).

    Roll, pitch and yaw, or `axes`: the body's x, y and z as axes of the sensor. With the sensor's x to the right and y
    ahead: `+y-x+z`, or a yaw of -90.
    """

    roll_deg: Degrees = 0.0
    pitch_deg: Degrees = 0.0
    yaw_deg: Degrees = 0.0
    axes: Annotated[str, Meta(pattern="^([+-][xyz]){3}$(?!\\n)|^$(?!\\n)")] = ""

    def __post_init__(self) -> None:
        """Refuse axes that are not a right-handed frame, and both ways at once."""
        if self.axes:
            axis_map(self.axes)
            if self.roll_deg or self.pitch_deg or self.yaw_deg:
                raise ValueError("a mounting has either axes or angles, not both")

    def matrix(self) -> Matrix:
        """Return the rotation from the sensor's axes to the body's."""
        return axis_map(self.axes) if self.axes else rotation(self.roll_deg, self.pitch_deg, self.yaw_deg)


class AttitudeSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `attitude`; `device` is the inertial unit of the stored calibration.

    The gyro's zero is learnt at rest. Then no axis is off by more than `bias_limit_dps` or noisier than
    `still_noise_dps` (standard deviation), the field is steady, and the turn is below `still_dps`. A magnetic field is
    disturbed outside its limits, or when it differs from the calibrated one by `field_tolerance`. The heading then
    continues by gyro for `field_hold_s`, and is unknown afterwards. A compass that differs from the gyro by
    `compass_jump_deg` is not trusted for `compass_retrust_s`.
    """

    device: Name
    gyro: Annotated[bool, Meta(description="the unit has one; without: roll and pitch by gravity, no heading")] = True
    mounting: Mounting = Mounting()
    declination_deg: Annotated[
        float, Meta(ge=-180.0, le=180.0, description="of magnetic north, east of true north")
    ] = 0.0
    publish_hz: Annotated[float, Meta(ge=10.0, le=100.0)] = 25.0
    gain: Annotated[float, Meta(gt=0.0, le=10.0, description="how fast accelerometer and compass correct, per s")] = 0.5
    stale_s: Annotated[float, Meta(gt=0.0, le=2.0, description="nothing is known without a sample for so long")] = 0.2
    gap_s: Annotated[float, Meta(gt=0.0, le=1.0, description="a longer gap ends the count of the turn")] = 0.1
    recover_s: Annotated[float, Meta(ge=0.0, le=2.0, description="good samples before it is valid again")] = 0.1
    gyro_limit_dps: Annotated[float, Meta(gt=0.0, le=4000.0, description="a faster turn is not believed")] = 500.0
    gyro_jump_dps: Annotated[
        float, Meta(gt=0.0, le=4000.0, description="a greater change between samples is an error")
    ] = 100.0
    accel_min_mps2: Annotated[float, Meta(ge=0.0, le=100.0)] = 5.0
    accel_max_mps2: Annotated[float, Meta(ge=0.0, le=1000.0)] = 18.0
    frozen_s: Annotated[float, Meta(gt=0.0, le=10.0, description="a gyro unchanged for so long is frozen")] = 0.5
    still_dps: Annotated[float, Meta(gt=0.0, le=20.0)] = 1.5
    still_noise_dps: Annotated[float, Meta(gt=0.0, le=20.0)] = 0.5
    bias_limit_dps: Annotated[float, Meta(gt=0.0, le=100.0)] = 25.0
    field_min_ut: MicroTesla = 15.0
    field_max_ut: MicroTesla = 90.0
    field_tolerance: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.35
    field_hold_s: Seconds = 1.0
    compass_jump_deg: Annotated[float, Meta(gt=0.0, le=180.0)] = 20.0
    compass_retrust_s: Seconds = 10.0
    observe_s: Annotated[float, Meta(gt=0.0, le=86400.0, description="a turn unseen for so long is given up")] = 600.0
    spin_power: Annotated[float, Meta(gt=0.0, le=1.0, description="of the turn on the spot that calibrates")] = 0.2
    sample_s: Annotated[float, Meta(ge=0.0, le=10.0, description="between two samples of a calibration")] = 0.04
    reverse_s: Annotated[float, Meta(gt=1.0, le=3600.0, description="then a calibration turns the other way")] = 25.0
    calibration_limit_s: Annotated[float, Meta(gt=1.0, le=3600.0, description="longest calibration")] = 120.0
    min_coverage: Annotated[float, Meta(gt=0.0, le=1.0, description="part of a full turn needed")] = 0.75
    max_residual: Annotated[float, Meta(gt=0.0, le=1.0, description="of a fit, as a part of the field")] = 0.06
