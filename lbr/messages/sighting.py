"""Messages on `sighting/*`: what a camera is watched for, and where it is seen."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.tracking import Target

MOST_S = 120.0


class WatchCommand(Struct, frozen=True, kw_only=True):
    """Look for a target in the camera's pictures for so many seconds from now on; 0: look no longer.

    Asked again before that it goes on for as long again; asked for another target, it looks for that alone.
    """

    target: Target = "colour"
    seconds: Annotated[float, Meta(ge=0.0, le=MOST_S)] = 60.0


class SightingState(Struct, frozen=True, kw_only=True):
    """The search for a target: for how much longer, and where it is, if the newest picture shows it.

    `bearing_deg` is from straight ahead of the robot, to the right positive, as the drive turns. `wide_deg` is how wide
    it appears, `distance_m` how far it is from the camera, if its true diameter is known. `age_s` is how long ago a
    picture was taken that shows it. `reason` is why nothing is seen.
    """

    watching: bool
    target: Target = "colour"
    left_s: float = 0.0
    seen: bool = False
    bearing_deg: Annotated[float, Meta(ge=-180.0, le=180.0)] | None = None
    wide_deg: Annotated[float, Meta(ge=0.0, le=180.0)] | None = None
    distance_m: Annotated[float, Meta(ge=0.0)] | None = None
    age_s: float | None = None
    pictures_hz: float = 0.0
    reason: str = ""
