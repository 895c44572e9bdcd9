"""InvenSense MPU-9150 on i2c, an MPU-6050 with an AK8975 compass in one package: its kind and its settings."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.imu import ImuSample
from lbr.messages.units import Name


class Mpu9150Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `mpu9150` may set."""

    device: Name


KIND = Kind(
    name="mpu9150",
    summary="MPU-9150 inertial unit with compass, on i2c",
    family="driver",
    entry="lbr.drivers.mpu9150.capability:Mpu9150",
    settings=Mpu9150Settings,
    outputs={"sample": ImuSample},
    device="mpu9150",
    emulated="socket",
)
