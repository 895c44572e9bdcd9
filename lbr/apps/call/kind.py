"""The kind `call`: its settings, ports and words."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.apps.call.messages import CallState, CallWord, KeepCommand, RingCommand, RingReply
from lbr.capability.kind import Command, Kind
from lbr.capability.word import Word
from lbr.messages.camera import CameraState, JpegFrame
from lbr.messages.system import Role
from lbr.messages.units import basic


class CallSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `call`."""

    answer: Annotated[
        Literal["ask", "at_once"],
        basic("calls", "Who answers", description="ask: a person at the robot; at_once: always"),
    ] = "ask"
    callers: Annotated[Role, Meta(description="the least role that may call")] = "operate"
    watchers: Annotated[Role, Meta(description="least role to watch by WebRTC, without sound")] = "view"
    most: Annotated[
        int, Meta(ge=1, le=8, description="pages with WebRTC, each encoded by itself; others get MJPEG")
    ] = 2
    ring_s: Annotated[float, Meta(ge=1.0, le=300.0, description="an unanswered call ends")] = 45.0
    microphone: Annotated[
        str,
        Meta(
            pattern="^[A-Za-z0-9_:,.=-]{0,80}$(?!\\n)",
            description="for arecord, such as default or plughw:1; tone: a test tone; empty: none",
        ),
    ] = "default"


KIND = Kind(
    name="call",
    summary="calls from the page: picture and sound both ways, by WebRTC",
    family="app",
    entry="lbr.apps.call.capability:Call",
    settings=CallSettings,
    inputs={"frames": JpegFrame, "cameras": CameraState},
    optional=("frames", "cameras"),
    outputs={"state": CallState},
    commands={
        "ring": Command(RingCommand, role="admin"),
        "keep": Command(KeepCommand, role="admin"),
        "answer": Command(CallWord, role="admin"),
        **dict.fromkeys(("decline", "end"), CallWord),
    },
    replies={"ring": RingReply, "keep": RingReply},
    words=(
        Word("/call/answer", "answer", "Answer the call that rings"),
        Word("/call/decline", "decline", "Decline the call that rings"),
        Word("/call/end", "end", "End the call that goes on, or rings"),
    ),
)
