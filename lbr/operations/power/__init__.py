"""Power: watches the supply, and shuts the computer down file-safe before it fails."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.joints import PlayCommand, TorqueCommand
from lbr.messages.leases import CommandReply
from lbr.messages.power import ArmCommand, CancelCommand, PowerState, UpsState
from lbr.messages.speech import SayCommand
from lbr.messages.units import Name


class PowerSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `power` may set; `device` is the supply whose thresholds it keeps."""

    device: Name


KIND = Kind(
    name="power",
    summary="power state, and a shutdown of the computer in time",
    family="operation",
    entry="lbr.operations.power.capability:Power",
    settings=PowerSettings,
    inputs={"ups": UpsState},
    outputs={"state": PowerState},
    commands={"arm": ArmCommand, "cancel": CancelCommand},
    replies=dict.fromkeys(("arm", "cancel"), CommandReply),
    requests={"park": PlayCommand, "let_go": TorqueCommand, "say": SayCommand},
    roles={"arm": "admin"},
    calibrates="device",
)
