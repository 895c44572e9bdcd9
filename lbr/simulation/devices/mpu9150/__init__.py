"""The emulated inertial unit MPU-9150: the settings of its device rows, its faults, and its twin."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import I2cFaults, Probability

Byte = Annotated[int, Meta(ge=0, le=255)]


class Mpu9150Faults(I2cFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of an MPU-9150: those of its bus, and more.

    `jump`: a turn rate is off by 4 rad/s. `noise`: times the usual, added. `no_compass`, `overflow`: the compass is
    silent, or reports too strong a field. After a `brown_out` it sleeps, without its settings.
    """

    frozen: bool = False
    jump: Probability = 0.0
    noise: Annotated[float, Meta(ge=0.0, le=1000.0)] = 0.0
    no_compass: bool = False
    overflow: bool = False


class Mpu9150Row(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The address of an `mpu9150` device row's chip (0x69 with AD0 high), and its compass's fuses (ASA of x, y, z)."""

    faults: Mpu9150Faults = Mpu9150Faults()
    i2c_address: Literal[0x68, 0x69] = 0x68
    sensitivity: tuple[Byte, Byte, Byte] = (176, 178, 166)


TWIN = DeviceTwin(device="mpu9150", row=Mpu9150Row, entry="lbr.simulation.devices.mpu9150.twin:Mpu9150Twin")
