"""Messages on `call/*`: a call from a page, with picture and sound both ways."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.system import Role

Hears = Literal["microphone", "tone", "silence"]
CallPhase = Literal["idle", "ringing", "connecting", "talking"]
Purpose = Literal["talk", "watch", "display"]
LONGEST_OFFER = 32_768
"""The most characters of an offer; browsers write about eight thousand."""
GuestId = Annotated[str, Meta(min_length=1, max_length=40, description="from the page's ring")]
Offer = Annotated[str, Meta(min_length=1, max_length=LONGEST_OFFER, description="a browser's offer (SDP)")]


class RingCommand(Struct, frozen=True, kw_only=True):
    """Let a page in to call, to watch without sound, or as the robot's display, which shows the caller. The web server
    adds the asker's rights.
    """

    purpose: Purpose = "talk"
    offer: Offer
    by: Annotated[str, Meta(max_length=120)] = ""
    role: Role | None = None


class KeepCommand(Struct, frozen=True, kw_only=True):
    """Report that a page is present, and get the state of its call; or that it leaves."""

    id: GuestId
    leave: bool = False


class CallWord(Struct, frozen=True, kw_only=True):
    """The owner's word about the call that rings or goes on, by the command's name."""


class RingReply(Struct, frozen=True, kw_only=True):
    """The state of a page's call. `answer`: the robot's part of the connection (SDP), once it exists.

    `picture`: why no picture comes; empty: it does. `hears`: the kind of sound that the caller gets;
    `sound`: the same in words. `seen`: a display shows the caller.
    """

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    id: str = ""
    phase: CallPhase = "idle"
    answer: str = ""
    picture: str = ""
    hears: Hears = "silence"
    sound: str = ""
    seen: bool = False


class CallState(Struct, frozen=True, kw_only=True):
    """The caller and the call; `by_webrtc` pages get pictures by WebRTC, at most `most`, displays not counted.

    `picture`: why no picture comes; empty: `camera` sends one. `hears`: the kind of sound that the caller
    gets; `sound`: the same in words. `lacks`: why no call is possible; `reason`: how the last one ended.
    """

    phase: CallPhase = "idle"
    caller: str = ""
    at_once: bool = False
    by_webrtc: int = 0
    most: int = 0
    displays: int = 0
    camera: str = ""
    picture: str = ""
    hears: Hears = "silence"
    sound: str = ""
    reason: str = ""
    code: ReasonCode = ""
    calls: int = 0
    lacks: str = ""
