"""Messages on `tracking/*`: what the head looks for and where it is seen."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.leases import LeaseId
from lbr.messages.units import TtlS

Target = Literal["colour", "face"]


class TrackCommand(Struct, frozen=True, kw_only=True):
    """Turn the head after a target, for as long as the lease is renewed."""

    target: Target = "colour"
    lease: LeaseId = ""
    ttl_s: TtlS | None = None
    take_over: bool = False


class Seen(Struct, frozen=True, kw_only=True):
    """A target in a picture: its middle and its radius as shares of the picture's width, x to the right, y down from the middle."""

    x: Annotated[float, Meta(ge=-1.0, le=1.0)]
    y: Annotated[float, Meta(ge=-1.0, le=1.0)]
    radius: Annotated[float, Meta(ge=0.0, le=1.0)]


class TrackingState(Struct, frozen=True, kw_only=True):
    """Whether the head follows something, what is seen, and where the head is asked to look (radians of its joints)."""

    following: bool
    target: Target = "colour"
    seen: Seen | None = None
    age_s: float | None = None
    yaw_rad: float | None = None
    pitch_rad: float | None = None
    pictures_hz: float = 0.0
    holder: str | None = None
    reason: str = ""
