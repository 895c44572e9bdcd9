"""The kind `tracking`: its settings, ports and words."""

from typing import Annotated

from msgspec import Meta

from lbr.apps.vision.settings import LOOK_WORDS, VisionSettings
from lbr.capability.kind import Kind
from lbr.capability.word import Word
from lbr.messages.camera import CameraState, JpegFrame, SnapshotReply
from lbr.messages.joints import Joint, JointsCommand, JointsState
from lbr.messages.leases import StopCommand
from lbr.messages.tracking import LookCommand, TrackCommand, TrackingState
from lbr.messages.units import Name, basic


class TrackingSettings(VisionSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `tracking`; the colour is an orange ball's, as hue, saturation and value.

    A hue from 350 to 10 goes over red. Yaw turns to the left, pitch downwards, the camera with both.
    """

    yaw_joint: Name = "neck_yaw"
    pitch_joint: Name = "head_pitch"
    dead_zone: Annotated[float, Meta(ge=0.0, le=5.0, description="in radii of the target: near enough")] = 0.75
    gain: Annotated[float, Meta(gt=0.0, le=1.0, description="1: the whole angle to it, at once")] = 0.5
    lost_s: Annotated[float, Meta(gt=0.0, le=60.0, description="how long the head stays at the last sight")] = 2.0
    ahead_rps: Annotated[float, Meta(ge=0.0, le=10.0, description="then it turns ahead; 0: it stays")] = 0.4
    give_up_s: Annotated[
        float,
        Meta(gt=0.0, le=86400.0, description="nothing seen for so long ends it and frees the joints"),
    ] = 120.0
    speed_rps: Annotated[float, basic("speed", "Speed of the head", gt=0.0, le=10.0, description="the head's most")] = (
        2.5
    )
    torque: Annotated[float, Meta(gt=0.0, le=1.0, description="of head and neck, a fraction of their most")] = 0.6


KIND = Kind(
    name="tracking",
    summary="turns the head after what its camera sees",
    family="app",
    entry="lbr.apps.vision.tracking.capability:Tracking",
    settings=TrackingSettings,
    inputs={"frame": JpegFrame, "camera": CameraState, "joints": JointsState},
    outputs={"state": TrackingState},
    commands={"track": TrackCommand, "stop": StopCommand, "look": LookCommand},
    requests={"move": JointsCommand, "halt": StopCommand},
    replies={"look": SnapshotReply},
    rows=(Joint,),
    words=(
        Word("track", "track", "Have the head follow the coloured thing, until a stop", {"target": "colour"}),
        Word("/track/{target}", "track", "Have the head follow: colour or face"),
        *LOOK_WORDS,
    ),
)
