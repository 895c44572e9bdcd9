"""Infrared receiver of the kernel's, hearing a dock's beams: its kind and its settings."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.dock import DockHeard, DockSignal
from lbr.messages.drive import CommandReply
from lbr.messages.units import Name


class InfraredSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `infrared` may set."""

    device: Name


KIND = Kind(
    name="infrared",
    summary="the infrared beams of a charging dock, by the kernel's remote control input",
    family="driver",
    entry="lbr.drivers.infrared.capability:Infrared",
    settings=InfraredSettings,
    outputs={"signal": DockSignal},
    commands={"heard": DockHeard},
    replies={"heard": CommandReply},
    device="infrared",
)
