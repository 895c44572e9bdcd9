"""Cameras: V4L2, the Raspberry Pi's own, or a stream of pictures on a socket; their kind and its settings."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, OnDevice
from lbr.messages.camera import CameraState, JpegFrame, SnapshotCommand, SnapshotReply, SwitchCommand
from lbr.messages.units import Name, basic

Pixels = Annotated[int, Meta(ge=16, le=4096)]
ControlName = Annotated[str, Meta(min_length=1, max_length=80)]


class CameraSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `camera`; its state reports the values that the camera really uses.

    `controls`: the camera's own, named as in V4L2 (`v4l2-ctl --list-ctrls`) or libcamera; all others stay unchanged.
    """

    device: Name
    on: Annotated[bool, basic("cameras", "On from the start", description="switched on at the start")] = False
    width_px: Pixels = 640
    height_px: Pixels = 360
    fps: Annotated[int, basic("cameras", "Pictures a second", ge=1, le=120, description="pictures a second")] = 15
    controls: dict[ControlName, int | float] = {}
    rotation_deg: Annotated[Literal[0, 180], Meta(description="for a csi camera upside down")] = 0


KIND = Kind(
    name="camera",
    summary="a camera: its newest picture, and a switch that closes it",
    family="driver",
    entry="lbr.drivers.camera.capability:Camera",
    settings=CameraSettings,
    outputs={"frame": JpegFrame, "state": CameraState},
    commands={"switch": SwitchCommand, "snapshot": SnapshotCommand},
    replies={"snapshot": SnapshotReply},
    device=OnDevice("camera", emulated="socket", recognised="lbr.drivers.camera.recognition:HANDSHAKE"),
)
