"""The kind `world`: its settings, ports and words."""

from lbr.capability.kind import Command, Kind, Needs, Rights
from lbr.capability.word import Word
from lbr.messages.kinematics import Kinematics, Wheel
from lbr.messages.sensing import RangeSensor
from lbr.simulation.messages import WorldPose, WorldScene
from lbr.simulation.requests import (
    BallReply,
    BallRequest,
    FaultReply,
    FaultRequest,
    PictureReply,
    PictureRequest,
    PlaceRequest,
    PlugRequest,
    RemoveRequest,
    ThingsReply,
)
from lbr.simulation.settings import WorldSettings
from lbr.simulation.words import BALL_WORDS, FAULT_WORDS

KIND = Kind(
    name="world",
    summary="a simulated room and robot, and an emulated twin on a pseudo-terminal for each of its devices",
    family="simulation",
    needs=Needs("mujoco", extra="sim"),
    entry="lbr.simulation.capability:World",
    settings=WorldSettings,
    outputs={"pose": WorldPose, "scene": WorldScene},
    commands={
        "picture": Command(PictureRequest, role="admin"),
        "fault": Command(FaultRequest, choices={"device": lambda known: known.devices}, role="admin"),
        "plug": Command(PlugRequest, role="admin"),
        "place": Command(PlaceRequest, role="admin"),
        "remove": Command(RemoveRequest, role="admin"),
        "ball": BallRequest,
    },
    rights=Rights(emulates=True),
    rows=(RangeSensor, Kinematics, Wheel),
    replies={
        "picture": PictureReply,
        "fault": FaultReply,
        "place": ThingsReply,
        "remove": ThingsReply,
        "ball": BallReply,
    },
    words=(
        Word("map", "picture", "Simulation: save a picture of the surroundings from above"),
        Word("picture", "picture", "Simulation: save a picture of the surroundings from above"),
        Word(
            "/obstacle/{x_m}/{y_m}",
            "place",
            "Simulation: put a box of 0.3 m there, metres ahead and to the left of the world's origin",
        ),
        Word("/obstacle/off", "remove", "Simulation: let that box vanish"),
        *BALL_WORDS,
        *FAULT_WORDS,
    ),
)
