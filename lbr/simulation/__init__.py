"""The simulated world: physics, emulated devices that speak the real bytes, and a view from above."""

from lbr.capability.kind import Command, Kind
from lbr.messages.simulation import WorldPose, WorldScene
from lbr.simulation.requests import (
    FaultReply,
    FaultRequest,
    PictureReply,
    PictureRequest,
    PlaceRequest,
    RemoveRequest,
    ThingsReply,
)
from lbr.simulation.settings import WorldSettings

KIND = Kind(
    name="world",
    summary="a simulated room and robot, and an emulated twin on a pseudo-terminal for each of its devices",
    family="simulation",
    extra="sim",
    package="mujoco",
    entry="lbr.simulation.capability:World",
    settings=WorldSettings,
    outputs={"pose": WorldPose, "scene": WorldScene},
    commands={
        "picture": PictureRequest,
        "fault": Command(FaultRequest, choices={"device": lambda known: known.devices}),
        "place": PlaceRequest,
        "remove": RemoveRequest,
    },
    roles={"picture": "admin", "fault": "admin", "place": "admin", "remove": "admin"},
    emulates=True,
    replies={"picture": PictureReply, "fault": FaultReply, "place": ThingsReply, "remove": ThingsReply},
)
