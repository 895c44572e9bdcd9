"""The simulated world of a humanoid: its body in the physics engine, and emulated twins of its devices."""

from lbr.capability.kind import Command, Kind, Needs, Rights, names
from lbr.capability.word import Word
from lbr.messages.joints import Joint
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.messages import HumanoidPose
from lbr.simulation.requests import (
    BallReply,
    BallRequest,
    FaultReply,
    FaultRequest,
    HandRequest,
    PickUpReply,
    PickUpRequest,
    PictureReply,
    PictureRequest,
    PlugRequest,
)
from lbr.simulation.words import BALL_WORDS, FAULT_WORDS

KIND = Kind(
    name="humanoid_world",
    summary="a simulated humanoid on a floor, and an emulated twin for each of its devices",
    family="simulation",
    needs=Needs("mujoco", extra="sim"),
    entry="lbr.simulation.humanoid.capability:HumanoidWorld",
    settings=HumanoidWorldSettings,
    outputs={"pose": HumanoidPose},
    commands={
        "picture": Command(PictureRequest, role="admin"),
        "fault": Command(FaultRequest, choices={"device": lambda known: known.devices}, role="admin"),
        "plug": Command(PlugRequest, role="admin"),
        "pick_up": PickUpRequest,
        "ball": BallRequest,
        "hand": Command(HandRequest, choices={"joint": names(Joint)}),
    },
    rights=Rights(emulates=True),
    replies={"picture": PictureReply, "fault": FaultReply, "pick_up": PickUpReply, "ball": BallReply},
    rows=(Joint,),
    words=(
        Word("picture", "picture", "Simulation: save a picture of the robot from its front and its left"),
        Word(
            "pick_up",
            "pick_up",
            "Simulation: put the robot on its feet, in a hand that holds it until its joints have torque",
        ),
        *BALL_WORDS,
        Word(
            "/hand/{joint}/{angle_deg}",
            "hand",
            "Simulation: have a hand move a joint there, in degrees, and hold it; one without torque gives way",
        ),
        Word("/hand/off", "hand", "Simulation: have the hand leave all joints", {"gone": True}),
        *FAULT_WORDS,
    ),
)
