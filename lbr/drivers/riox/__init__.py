"""Roboteq RIOX-1216AHRS on a serial line: its kind and its settings."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, OnDevice
from lbr.messages.imu import ImuSample
from lbr.messages.units import Name


class RioxSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `riox`.

    No manual confirms the scales, which come from earlier robots: compare them with a known turn, tilt and field.
    `echo`: the unit repeats each query, and its answer follows the echo.
    """

    device: Name
    rate_hz: Annotated[float, Meta(ge=5.0, le=100.0, description="most samples per second")] = 50.0
    orientation: Annotated[bool, Meta(description="also ask for the unit's own orientation")] = True
    echo: bool = False
    answer_s: Annotated[float, Meta(ge=0.02, le=1.0, description="a later answer is lost")] = 0.1
    timeout_s: Annotated[float, Meta(ge=0.1, le=5.0, description="silence that counts as a fault")] = 0.5
    gyro_lsb_per_dps: Annotated[float, Meta(gt=0.0, le=10000.0, description="unverified; 1000 deg/s full scale")] = (
        32.75
    )
    accel_lsb_per_g: Annotated[float, Meta(gt=0.0, le=100000.0, description="unverified; 2 g full scale")] = 16384.0
    mag_ut_per_lsb: Annotated[float, Meta(gt=0.0, le=100.0, description="unverified; microtesla")] = 0.3
    temperature_lsb_per_c: Annotated[float, Meta(gt=0.0, le=10000.0, description="unverified")] = 340.0
    temperature_offset_c: Annotated[
        float, Meta(ge=-100.0, le=100.0, description="unverified; where the sensor reads zero")
    ] = 35.0
    quaternion_divisor: Annotated[
        float, Meta(gt=0.0, le=1e6, description="unverified; what one is in the orientation's numbers")
    ] = 16384.0
    baud: Literal[9600, 57600, 115200] = 115200


KIND = Kind(
    name="riox",
    summary="Roboteq RIOX inertial unit with compass, on a serial line",
    family="driver",
    entry="lbr.drivers.riox.capability:Riox",
    settings=RioxSettings,
    outputs={"sample": ImuSample},
    device=OnDevice("riox", line="serial", recognised="lbr.drivers.riox.recognition:HANDSHAKE"),
)
