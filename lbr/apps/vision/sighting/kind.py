"""The kind `sighting`: its settings, ports and words."""

from typing import Annotated

from msgspec import Meta

from lbr.apps.vision.settings import LOOK_WORDS, VisionSettings
from lbr.capability.kind import Kind
from lbr.capability.word import Word
from lbr.messages.camera import CameraState, JpegFrame, SnapshotReply
from lbr.messages.sighting import SightingState, WatchCommand
from lbr.messages.tracking import LookCommand

Turned = Annotated[float, Meta(ge=-180.0, le=180.0)]


class SightingSettings(VisionSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `sighting`; the colour is an orange ball's, as hue, saturation and value.

    A hue from 350 to 10 goes over red. The camera is turned `yaw_deg` to the left, `pitch_deg` downwards.
    """

    yaw_deg: Turned = 0.0
    pitch_deg: Turned = 0.0
    diameter_m: (
        Annotated[float, Meta(gt=0.0, le=10.0, description="of the target; null: no distance is reported")] | None
    ) = None


KIND = Kind(
    name="sighting",
    summary="reports where a camera sees a coloured thing or a face, on request",
    family="app",
    entry="lbr.apps.vision.sighting.capability:Sighting",
    settings=SightingSettings,
    inputs={"frame": JpegFrame, "camera": CameraState},
    outputs={"state": SightingState},
    commands={"watch": WatchCommand, "look": LookCommand},
    replies={"look": SnapshotReply},
    words=(
        Word("/watch/{target}", "watch", "Look out for a minute for: colour or face; it moves nothing"),
        Word("/watch/off", "watch", "Look out no longer", {"seconds": 0.0}),
        *LOOK_WORDS,
    ),
)
