"""PhidgetSpatial 3/3/3 inertial units (1042, 1044, 1056) by Phidgets' own library: their kind and their settings."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Kind
from lbr.messages.imu import ImuSample
from lbr.messages.units import Name


class PhidgetSpatialSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `phidget_spatial` may set."""

    device: Name
    interval_ms: Annotated[int, Meta(ge=4, le=1000, description="between two samples: 4, or a multiple of 8")] = 4


KIND = Kind(
    name="phidget_spatial",
    summary="PhidgetSpatial 3/3/3 inertial unit with compass, on USB",
    family="driver",
    entry="lbr.drivers.phidget_spatial.capability:PhidgetSpatial",
    settings=PhidgetSpatialSettings,
    outputs={"sample": ImuSample},
    device="phidget_spatial",
    emulated="socket",
)
