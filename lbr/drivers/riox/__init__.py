"""Roboteq RIOX-1216AHRS on a serial line: its kind and its settings."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.imu import ImuSample
from lbr.messages.units import Name


class RioxSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `riox` may set."""

    device: Name


KIND = Kind(
    name="riox",
    summary="Roboteq RIOX inertial unit with compass, on a serial line",
    family="driver",
    entry="lbr.drivers.riox.capability:Riox",
    settings=RioxSettings,
    outputs={"sample": ImuSample},
    device="riox",
)
