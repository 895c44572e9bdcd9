"""Messages on `dance/*`."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.rows import Row
from lbr.messages.units import AngleDeg, Name, Power, StepNumber


class DanceStep(Row, frozen=True, kw_only=True):
    """The dances of the robots: one move after the other, to the beats of a song."""

    TABLE = "choreography"
    KEY = ("dance", "step")

    dance: Annotated[Name, "its name in settings and commands"]
    step: Annotated[StepNumber, "its place in the order, from 1; after the last comes the first"]
    power: Power
    angle_deg: AngleDeg
    beats: Annotated[int, Meta(ge=1, le=64), "for how many beats"] = 1


class DanceCommand(Struct, frozen=True, kw_only=True):
    """Dance to a song: `<song>.wav` and its beats `<song>.json` below `$LBR_HOME/music`."""

    song: Annotated[str, Meta(min_length=1, max_length=80)]
    dance: Annotated[str, Meta(max_length=40, description="choreography; empty: the settings'")] = ""


class DanceState(Struct, frozen=True, kw_only=True):
    """The dance under way; `beat` counts from 1. `reason`: the last end."""

    phase: Literal["resting", "dancing", "ended"]
    song: str = ""
    dance: str = ""
    beat: int = 0
    beats: int = 0
    moves: int = 0
    reason: str = ""
    code: ReasonCode = ""
