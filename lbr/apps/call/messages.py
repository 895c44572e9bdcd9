"""Messages on `call/*`: a call from a page, with picture and sound both ways."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.system import Role

Hears = Literal["microphone", "tone", "silence"]
CallPhase = Literal["idle", "ringing", "connecting", "talking"]
Purpose = Literal["talk", "watch", "display"]
LONGEST_OFFER = 32_768
"""Characters of an offer. Browsers write some eight thousand."""
GuestId = Annotated[str, Meta(min_length=1, max_length=40, description="what a page was told when it rang")]
Offer = Annotated[str, Meta(min_length=1, max_length=LONGEST_OFFER, description="a browser's offer (SDP)")]


class RingCommand(Struct, frozen=True, kw_only=True):
    """Let a page in: to call, to watch without sound, or as the robot's own display, which shows the caller.

    The web server adds the asker and its rights.
    """

    purpose: Purpose = "talk"
    offer: Offer
    by: Annotated[str, Meta(max_length=120)] = ""
    role: Role | None = None


class KeepCommand(Struct, frozen=True, kw_only=True):
    """Say that a page is still there, and be told how its call is; or that it leaves."""

    id: GuestId
    leave: bool = False


class CallWord(Struct, frozen=True, kw_only=True):
    """A word of the robot's owner about the call that rings or goes on: which one is the command's name."""


class RingReply(Struct, frozen=True, kw_only=True):
    """The state of a page's call. `answer` is the robot's part of the connection (SDP), once it exists.

    `picture` says why no picture comes (empty: it does), `hears` and `sound` what the caller hears, `seen` whether a
    display of the robot shows the caller.
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
    """The caller, and the state of the call; `by_webrtc` pages get their picture by WebRTC, of at most `most`, displays
    not counted.

    `picture` says why no picture comes (empty: it does, of `camera`); `hears` and `sound` what a caller hears; `lacks`
    why no call can be made at all, `reason` how the last call ended.
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
