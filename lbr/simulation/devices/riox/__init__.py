"""The emulated inertial unit RIOX-1216AHRS: the settings of its device rows, its faults, and its twin."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import LineFaults, Probability

Scale = Annotated[float, Meta(gt=0.0, le=1e6)]


class RioxFaults(LineFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a RIOX: those of a line, and more. `pieces`: pauses in answers. `jump`: a turn rate off by 4 rad/s."""

    half: Probability = 0.0
    pieces: bool = False
    frozen: bool = False
    jump: Probability = 0.0


class RioxRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The counts of a `riox` device row's unit; `echo`: it repeats its input, until a command ends that."""

    faults: RioxFaults = RioxFaults()
    echo: bool = True
    gyro_lsb_per_dps: Scale = 32.75
    accel_lsb_per_g: Scale = 16384.0
    mag_ut_per_lsb: Scale = 0.3
    temperature_lsb_per_c: Scale = 340.0
    temperature_offset_c: float = 35.0
    quaternion_divisor: Scale = 16384.0
    euler_lsb_per_deg: Scale = 10.0


TWIN = DeviceTwin(device="riox", row=RioxRow, entry="lbr.simulation.devices.riox.twin:RioxTwin")
