"""Messages on `sighting/*`: the target that a camera looks for, and its place."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.tracking import Target

MOST_S = 120.0


class WatchCommand(Struct, frozen=True, kw_only=True):
    """Look for a target in the camera's pictures for so many seconds; 0 ends it.

    A repetition looks for as long again, or for the new target alone.
    """

    target: Target = "colour"
    seconds: Annotated[float, Meta(ge=0.0, le=MOST_S)] = 60.0


class SightingState(Struct, frozen=True, kw_only=True):
    """The search for a target, the time left, and where the target is, if the newest picture shows it.

    `bearing_deg`: from straight ahead, to the right positive. `wide_deg`: how wide it appears. `distance_m`: from the
    camera, if its true diameter is known. `age_s`: of the last picture that shows it.
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
