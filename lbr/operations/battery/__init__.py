"""Battery: charge and charging, from what the motor controller measures."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.battery import BatteryState
from lbr.messages.drive import CommandReply
from lbr.messages.motors import MotorsState
from lbr.messages.speech import SayCommand


class BatterySettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `battery` may set."""


KIND = Kind(
    name="battery",
    summary="charge, charging and low-battery warnings of a lead-acid battery",
    family="operation",
    entry="lbr.operations.battery.capability:Battery",
    settings=BatterySettings,
    inputs={"motors": MotorsState},
    outputs={"state": BatteryState},
    requests={"say": SayCommand},
    replies={"say": CommandReply},
)
