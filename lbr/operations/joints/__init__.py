"""Joints operation: one holder, leases, limits and smooth ways between joint commands and the servos of a humanoid."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Kind
from lbr.messages.drive import GoalResult
from lbr.messages.joints import JointMove, JointsCommand, JointsState, RecoverCommand, TorqueCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.servos import RecoverServos, ServoSetpoint, ServosState
from lbr.messages.units import TtlS


class JointsSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `joints` may set."""

    rate_hz: Annotated[float, Meta(ge=10.0, le=200.0, description="setpoints per second")] = 100.0
    ttl_s: TtlS = 0.3


KIND = Kind(
    name="joints",
    summary="decides what the joints of a humanoid do, for whom, and for how long",
    family="operation",
    entry="lbr.operations.joints.capability:Joints",
    settings=JointsSettings,
    inputs={"servos": ServosState},
    outputs={"setpoint": ServoSetpoint, "state": JointsState, "result": GoalResult},
    commands={
        "command": JointsCommand,
        "move": JointMove,
        "torque": TorqueCommand,
        "recover": RecoverCommand,
        "stop": StopCommand,
    },
    replies=dict.fromkeys(("command", "move", "torque", "recover", "stop"), CommandReply),
    requests={"servos_recover": RecoverServos},
    moves=True,
    rows=("joint",),
)
