"""The simulated world of a humanoid: its body in the physics engine, and emulated twins of its devices."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Kind
from lbr.messages.simulation import WorldPose
from lbr.messages.units import Name
from lbr.simulation.requests import FaultReply, FaultRequest, PictureReply, PictureRequest


class HumanoidWorldSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The simulated humanoid: `model` is a body, shipped or in `$LBR_HOME/models`, whose joints bear the rows' names."""

    model: Name
    seed: int = 1
    stand: Annotated[bool, Meta(description="hung up by its trunk, so that it cannot fall")] = False
    pose_hz: Annotated[float, Meta(ge=1.0, le=100.0)] = 20.0


KIND = Kind(
    name="humanoid_world",
    summary="a simulated humanoid on a floor, and an emulated twin for each of its devices",
    family="simulation",
    entry="lbr.simulation.humanoid.capability:HumanoidWorld",
    settings=HumanoidWorldSettings,
    outputs={"pose": WorldPose},
    commands={"picture": PictureRequest, "fault": FaultRequest},
    roles={"picture": "admin", "fault": "admin"},
    replies={"picture": PictureReply, "fault": FaultReply},
    rows=("joint",),
)
