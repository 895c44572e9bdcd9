"""The LD06 lidar, and its maker's compatible ones, on a serial line: its kind and its settings."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, OnDevice, Rows
from lbr.messages.sensing import RangeSensor, Scan
from lbr.messages.units import Name


class Ld06Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `ld06`; the row `sensor` of `range_sensor` has its place and range."""

    device: Name
    sensor: Name = "lidar"
    least_confidence: Annotated[int, Meta(ge=0, le=255, description="less sure distances do not count")] = 0
    timeout_s: Annotated[float, Meta(ge=0.1, le=5.0, description="silence that counts as a fault")] = 0.5
    start_timeout_s: Annotated[float, Meta(ge=0.1, le=10.0, description="until its mirror turns")] = 4.0


KIND = Kind(
    name="ld06",
    summary="LD06 lidar: scans all around, ten a second",
    family="driver",
    entry="lbr.drivers.ld06.capability:Ld06",
    settings=Ld06Settings,
    outputs={"scan": Scan},
    rows=(Rows(RangeSensor, where={"name": "sensor"}),),
    device=OnDevice("ld06", line="serial", recognised="lbr.drivers.ld06.recognition:HANDSHAKE"),
)
