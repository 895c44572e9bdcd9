"""Messages on `tracking/*`: the target that the head follows, and its place."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

Target = Literal["colour", "face"]


class TrackCommand(Struct, frozen=True, kw_only=True):
    """Turn the head after a target, until a stop of this or the joints, or until it is unseen for long.

    The sender renews nothing; the capability holds the lease of the joints.
    """

    target: Target = "colour"


class LookCommand(Struct, frozen=True, kw_only=True):
    """Look for a target in the newest picture, save it marked, and report the colour of its middle."""

    target: Target = "colour"


class Seen(Struct, frozen=True, kw_only=True):
    """A target in a picture: its middle and radius as shares of the width, x to the right, y down from the middle."""

    x: Annotated[float, Meta(ge=-1.0, le=1.0)]
    y: Annotated[float, Meta(ge=-1.0, le=1.0)]
    radius: Annotated[float, Meta(ge=0.0, le=1.0)]


class TrackingState(Struct, frozen=True, kw_only=True):
    """The target that the head follows, its place in the newest picture, and the direction asked of the head.

    `age_s`: of the last picture that shows it. `reason`: why the head stays, or how the last following ended.
    """

    following: bool
    target: Target = "colour"
    seen: Seen | None = None
    age_s: float | None = None
    yaw_rad: float | None = None
    pitch_rad: float | None = None
    pictures_hz: float = 0.0
    reason: str = ""
