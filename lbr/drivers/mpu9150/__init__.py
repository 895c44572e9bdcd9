"""InvenSense MPU-9150 on i2c, an MPU-6050 with an AK8975 compass in one package: its kind and its settings."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, OnDevice
from lbr.drivers.inertial import STILL_MPS2, STILL_RPS, StillMps2, StillRps
from lbr.messages.imu import ImuSample
from lbr.messages.units import Name


class Mpu9150Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `mpu9150`."""

    device: Name
    rate_hz: Annotated[float, Meta(ge=10.0, le=200.0, description="samples per second")] = 100.0
    gyro_range_dps: Annotated[
        Literal[250, 500, 1000, 2000], Meta(description="fastest turn it can measure, degrees per second")
    ] = 500
    accel_range_g: Annotated[
        Literal[2, 4, 8, 16], Meta(description="largest acceleration it can measure, in standard gravities")
    ] = 4
    lowpass_hz: Annotated[
        Literal[188, 98, 42, 20, 10, 5],
        Meta(description="bandwidth; below half of `rate_hz`, or vibration aliases"),
    ] = 42
    mag_hz: Annotated[float, Meta(ge=0.0, le=100.0, description="most compass readings per second; 0: none")] = 25.0
    temperature_offset_c: Annotated[float, Meta(ge=-100.0, le=100.0, description="where the sensor reads zero")] = 35.0
    still_rps: StillRps = STILL_RPS
    still_mps2: StillMps2 = STILL_MPS2
    most_errors: Annotated[int, Meta(ge=1, le=100, description="failed readings in a row before a restart")] = 5


KIND = Kind(
    name="mpu9150",
    summary="MPU-9150 inertial unit with compass, on i2c",
    family="driver",
    entry="lbr.drivers.mpu9150.capability:Mpu9150",
    settings=Mpu9150Settings,
    outputs={"sample": ImuSample},
    device=OnDevice("mpu9150", emulated="socket", recognised="lbr.drivers.mpu9150.recognition:HANDSHAKE"),
)
