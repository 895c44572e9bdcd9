"""The simulated world of a humanoid: its body in the physics engine, and emulated twins of its devices."""

from lbr.capability.kind import Command, Kind
from lbr.messages.joints import Joint
from lbr.messages.simulation import HumanoidPose
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.requests import (
    BallReply,
    BallRequest,
    FaultReply,
    FaultRequest,
    PickUpReply,
    PickUpRequest,
    PictureReply,
    PictureRequest,
)

KIND = Kind(
    name="humanoid_world",
    summary="a simulated humanoid on a floor, and an emulated twin for each of its devices",
    family="simulation",
    extra="sim",
    package="mujoco",
    entry="lbr.simulation.humanoid.capability:HumanoidWorld",
    settings=HumanoidWorldSettings,
    outputs={"pose": HumanoidPose},
    commands={
        "picture": PictureRequest,
        "fault": Command(FaultRequest, choices={"device": lambda known: known.devices}),
        "pick_up": PickUpRequest,
        "ball": BallRequest,
    },
    roles={"picture": "admin", "fault": "admin"},
    emulates=True,
    replies={"picture": PictureReply, "fault": FaultReply, "pick_up": PickUpReply, "ball": BallReply},
    rows=(Joint,),
)
