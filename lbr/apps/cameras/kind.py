"""The kind `cameras`: its settings, ports and words."""

from msgspec import Struct

from lbr.capability.kind import Command, Kind, Known
from lbr.capability.word import Word
from lbr.messages.camera import CamerasState, CameraState, SelectCommand, SwitchCommand


class CamerasSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `cameras`."""


OFF = "off"
_CAMERA = "camera_"


def _cameras(known: Known) -> set[str]:
    """Return the names to select: the cameras, and off."""
    return {OFF, *(name.removeprefix(_CAMERA) for name in known.wired if name.startswith(_CAMERA))}


KIND = Kind(
    name="cameras",
    summary="switches one of the robot's cameras on and the others off",
    family="app",
    entry="lbr.apps.cameras.capability:Cameras",
    settings=CamerasSettings,
    inputs={"states": CameraState},
    outputs={"state": CamerasState},
    commands={"select": Command(SelectCommand, choices={"name": _cameras})},
    requests={"switch": SwitchCommand},
    words=(Word("/camera/{name}", "select", "Switch a camera on and the others off, by its name, or off for none"),),
)
