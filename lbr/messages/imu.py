"""Messages on `imu/*`: the readings of an inertial unit."""

from msgspec import Struct

from lbr.messages.units import Quaternion, Vector


class ImuSample(Struct, frozen=True, kw_only=True):
    """One instant of an inertial unit, along the sensor's own right-handed axes, also of the magnetometer.

    `mag_ut` is null between two measurements of the slower magnetometer. `orientation` (w, x, y, z): the device's own,
    if it has one. `time_s`: measured then, by the monotonic clock of the driver's host. `span_s`: at rest it is the
    mean of some readings, the first of them so long before; 0 of a single one.
    """

    valid: bool
    time_s: float
    reason: str = ""
    gyro_rps: Vector | None = None
    accel_mps2: Vector | None = None
    mag_ut: Vector | None = None
    temperature_c: float | None = None
    orientation: Quaternion | None = None
    span_s: float = 0.0


class ZeroCommand(Struct, frozen=True, kw_only=True):
    """Measure the gyro's zero again; keep the robot still for two seconds."""
