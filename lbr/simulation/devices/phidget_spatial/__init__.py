"""The emulated inertial unit PhidgetSpatial: the settings of its device rows, its faults, and its twin."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import Faults


class PhidgetSpatialFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a PhidgetSpatial on USB. `jump`: the turn about x is off by 400 degrees a second. `no_compass`: no
    field.
    """

    silent: bool = False
    frozen: bool = False
    jump: bool = False
    no_compass: bool = False


class PhidgetSpatialRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The number of samples that a `phidget_spatial` device row's unit sends together."""

    faults: PhidgetSpatialFaults = PhidgetSpatialFaults()
    burst: Annotated[int, Meta(ge=1, le=8)] = 2


TWIN = DeviceTwin(
    device="phidget_spatial",
    row=PhidgetSpatialRow,
    entry="lbr.simulation.devices.phidget_spatial.twin:PhidgetSpatialTwin",
)
