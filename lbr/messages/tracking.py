"""Messages on `tracking/*`: what the head looks for and where it is seen."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

Target = Literal["colour", "face"]


class TrackCommand(Struct, frozen=True, kw_only=True):
    """Turn the head after a target from now on: until a stop, of this or of the joints, or until nothing is seen for
    long.

    The asker need not do more; the mover of the head borrows the joints, and ends with that lease.
    """

    target: Target = "colour"


class LookCommand(Struct, frozen=True, kw_only=True):
    """Look for a target in the newest picture, save it with what is seen marked, and say which colour its middle
    has."""

    target: Target = "colour"


class Seen(Struct, frozen=True, kw_only=True):
    """A target in a picture: its middle and its radius as shares of the picture's width, x to the right, y down from
    the middle."""

    x: Annotated[float, Meta(ge=-1.0, le=1.0)]
    y: Annotated[float, Meta(ge=-1.0, le=1.0)]
    radius: Annotated[float, Meta(ge=0.0, le=1.0)]


class TrackingState(Struct, frozen=True, kw_only=True):
    """The target that the head follows, its place in the newest picture, and the direction that is asked of the head.

    Both angles are radians of its joints. `age_s` is how long ago a picture was taken that shows the target. `reason`
    is why the head stays where it is, or how the last following ended.
    """

    following: bool
    target: Target = "colour"
    seen: Seen | None = None
    age_s: float | None = None
    yaw_rad: float | None = None
    pitch_rad: float | None = None
    pictures_hz: float = 0.0
    reason: str = ""
