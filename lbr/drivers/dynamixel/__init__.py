"""A bus of Dynamixel AX-12A servos, protocol 1.0: its kind and its settings."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind
from lbr.messages.leases import CommandReply
from lbr.messages.servos import RecoverServos, ServoSetpoint, ServosState
from lbr.messages.units import Name


class DynamixelSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `dynamixel` may set."""

    device: Name
    baud: Annotated[int, Meta(ge=7843, le=1_000_000)] = 1_000_000
    sweep_hz: Annotated[float, Meta(ge=1.0, le=250.0, description="sweeps per second at most")] = 100.0
    hold_s: Annotated[float, Meta(ge=0.0, le=3600.0, description="how long servos hold whose mover is lost")] = 30.0
    release_s: Annotated[
        float, Meta(ge=0.1, le=60.0, description="how long letting go takes then; their torque fades")
    ] = 5.0
    on_estop: Annotated[
        Literal["hold", "release"], Meta(description="what the emergency stop does: hold still, or let go at once")
    ] = "hold"


KIND = Kind(
    name="dynamixel",
    summary="a bus of Dynamixel AX-12A servos, protocol 1.0, plain or by a USB2AX",
    family="driver",
    entry="lbr.drivers.dynamixel.capability:Dynamixel",
    settings=DynamixelSettings,
    setpoints={"setpoint": ServoSetpoint},
    outputs={"state": ServosState},
    commands={"recover": RecoverServos},
    replies={"recover": CommandReply},
    moves=True,
    device="dynamixel",
    rows=("joint",),
)
