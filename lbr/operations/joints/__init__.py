"""Joints operation: one holder, leases, limits and smooth ways between joint commands and the servos of a humanoid."""

from lbr.capability.kind import Command, Kind, names
from lbr.messages.drive import GoalResult
from lbr.messages.joints import Joint, JointMove, JointsCommand, JointsState, RecoverCommand, TorqueCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.servos import RecoverServos, ServoSetpoint, ServosState
from lbr.operations.joints.settings import JointsSettings

KIND = Kind(
    name="joints",
    summary="decides what the joints of a humanoid do, for whom, and for how long",
    family="operation",
    entry="lbr.operations.joints.capability:Joints",
    settings=JointsSettings,
    inputs={"servos": ServosState},
    outputs={"setpoint": ServoSetpoint, "state": JointsState, "result": GoalResult},
    commands={
        "command": Command(JointsCommand, leased=True),
        "move": Command(JointMove, leased=True, choices={"joint": names(Joint)}),
        "torque": Command(TorqueCommand, choices={"joints": names(Joint)}),
        "recover": Command(RecoverCommand, choices={"joints": names(Joint)}),
        "stop": StopCommand,
    },
    replies=dict.fromkeys(("command", "move", "torque", "recover", "stop", "servos_recover"), CommandReply),
    requests={"servos_recover": RecoverServos},
    moves=True,
    rows=(Joint,),
)
