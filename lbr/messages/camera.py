"""Messages on `camera_*/*` and `cameras/*`."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.units import Name

CameraPhase = Literal["off", "opening", "streaming", "lost"]


class JpegFrame(Struct, frozen=True):
    """A picture: the bytes of a JPEG file (`image/jpeg`), stamped with its time."""

    data: bytes


class CameraState(Struct, frozen=True, kw_only=True):
    """The state of a camera. Off: its device is closed.

    Width, height and rate are those of its pictures. `dropped`: broken, too large, or overtaken by a newer one.
    `rests`: without a viewer, at two pictures a second.
    """

    on: bool
    phase: CameraPhase
    device: str
    width_px: int | None = None
    height_px: int | None = None
    fps: float | None = None
    frames: int = 0
    dropped: int = 0
    rests: bool = False
    reason: str = ""
    code: ReasonCode = ""


class SwitchCommand(Struct, frozen=True, kw_only=True):
    """Open the camera's device, or close it."""

    on: bool


class SnapshotCommand(Struct, frozen=True, kw_only=True):
    """Save the newest picture below `$LBR_HOME/pictures`, by this name, or by camera and time."""

    name: Annotated[str, Meta(max_length=80)] = ""


class SnapshotReply(Struct, frozen=True, kw_only=True):
    """The file of the picture."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    path: str = ""


class SelectCommand(Struct, frozen=True, kw_only=True):
    """Switch this camera on and all others off. `off`: none."""

    name: Name


class CamerasState(Struct, frozen=True, kw_only=True):
    """The camera that is on, and the state of each."""

    selected: str
    cameras: dict[str, CameraState]
