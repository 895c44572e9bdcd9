"""PhidgetSpatial 3/3/3 inertial units (1042, 1044, 1056) by Phidgets' own library: their kind and their settings."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, OnDevice
from lbr.capability.word import Word
from lbr.drivers.inertial import STILL_MPS2, STILL_RPS, StillMps2, StillRps
from lbr.messages.imu import ImuSample, ZeroCommand
from lbr.messages.units import Name


class PhidgetSpatialSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `phidget_spatial`.

    `gravity_sign` -1: the unit reads -1 g along the axis that points up, as these boards do.
    """

    device: Name
    interval_ms: Annotated[int, Meta(ge=4, le=1000, description="between two samples: 4, or a multiple of 8")] = 4
    gravity_sign: Literal[-1, 1] = -1
    still_rps: StillRps = STILL_RPS
    still_mps2: StillMps2 = STILL_MPS2
    zero_at_start: Annotated[bool, Meta(description="take the gyro's zero at each start, lying still")] = False

    def __post_init__(self) -> None:
        """Refuse intervals that no board supports."""
        if self.interval_ms != 4 and self.interval_ms % 8:
            raise ValueError(f"interval_ms {self.interval_ms}: these units know 4, and multiples of 8")


KIND = Kind(
    name="phidget_spatial",
    summary="PhidgetSpatial 3/3/3 inertial unit with compass, on USB",
    family="driver",
    entry="lbr.drivers.phidget_spatial.capability:PhidgetSpatial",
    settings=PhidgetSpatialSettings,
    outputs={"sample": ImuSample},
    commands={"zero": ZeroCommand},
    device=OnDevice("phidget_spatial", emulated="socket"),
    words=(
        Word("zero", "zero", "Take the zero of the inertial unit's gyro again; keep the robot still for two seconds"),
    ),
)
