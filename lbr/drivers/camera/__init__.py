"""Cameras: V4L2, the Raspberry Pi's own, or a stream of pictures on a socket; their kind and its settings."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.camera import CameraState, JpegFrame, SnapshotCommand, SnapshotReply, SwitchCommand
from lbr.messages.drive import CommandReply
from lbr.messages.units import Name


class CameraSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `camera` may set."""

    device: Name


KIND = Kind(
    name="camera",
    summary="a camera: its newest picture, and a switch that closes it",
    family="driver",
    entry="lbr.drivers.camera.capability:Camera",
    settings=CameraSettings,
    outputs={"frame": JpegFrame, "state": CameraState},
    commands={"switch": SwitchCommand, "snapshot": SnapshotCommand},
    replies={"switch": CommandReply, "snapshot": SnapshotReply},
    device="camera",
    emulated="socket",
)
