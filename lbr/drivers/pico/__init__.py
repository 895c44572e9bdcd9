"""UPS PIco HV3.0, an uninterruptible supply for the Raspberry Pi on i2c: its kind and its settings."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.leases import CommandReply
from lbr.messages.power import RelayCommand, UpsState
from lbr.messages.units import Name


class PicoSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `pico` may set."""

    device: Name


KIND = Kind(
    name="pico",
    summary="UPS PIco uninterruptible power supply, on i2c",
    family="driver",
    entry="lbr.drivers.pico.capability:Pico",
    settings=PicoSettings,
    outputs={"state": UpsState},
    commands={"relay": RelayCommand},
    replies={"relay": CommandReply},
    device="pico",
    emulated="socket",
)
