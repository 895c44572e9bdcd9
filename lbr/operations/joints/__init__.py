"""Joints operation: one holder, leases, limits and smooth ways between joint commands and the servos of a humanoid."""

from lbr.capability.kind import Command, Kind, Rows, names
from lbr.capability.word import Word
from lbr.messages.drive import GoalResult
from lbr.messages.joints import Joint, JointMove, JointsCommand, JointsState, RecoverCommand, TorqueCommand
from lbr.messages.leases import StopCommand
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
    requests={"servos_recover": RecoverServos},
    moves=True,
    rows=(Rows(Joint, where={"bus": "bus"}),),
    words=(
        Word(
            "/j/{joint}/{angle_deg}",
            "move",
            "Move a joint to an angle in degrees from its zero, at 30 degrees a second, such as /j/left_knee/60",
        ),
        Word(
            "/j/{joint}/{angle_deg}/{speed_dps}",
            "move",
            "The same at this many degrees a second, such as /j/left_knee/60/90; never faster than its row allows",
        ),
        Word("/torque/on", "torque", "Switch the torque of all joints on: each stays where it is", {"on": True}),
        Word(
            "/torque/on/{joints}",
            "torque",
            "Switch the torque of a joint on, or of several, such as /torque/on/left_elbow,right_elbow",
            {"on": True},
        ),
        Word(
            "/torque/off/{joints}",
            "torque",
            "Release a joint, or several, such as /torque/off/left_elbow, so that a hand can move it",
            {"on": False},
        ),
        Word("/torque/off", "torque", "Release all joints, after a confirmation", {"on": False}),
        Word(
            "/torque/off/all",
            "torque",
            "Release all joints at once: the robot falls unless it sits or is held",
            {"on": False, "confirmed": True},
        ),
        Word(
            "recover",
            "recover",
            "Recover all joints from latched faults, such as an overload whose cause is gone; moves nothing",
        ),
        Word("/recover/{joints}", "recover", "Recover a joint, or several, such as /recover/left_knee"),
    ),
)
