"""Queries and bodies of the API, as its document describes them."""

from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from lbr.messages.faces import Label, Text
from lbr.messages.joints import MAX_FRAMES, DurationS, JointRad
from lbr.messages.units import Name

Id = Annotated[int, Meta(description="the motor's number")]
Position = Annotated[float, Meta(description="where to go: a count of the servo, unless `unit` names another; clamped")]
Torque = Annotated[float, Meta(description="0, the strongest, to 4, the weakest; clamped")]
DelayMs = Annotated[float, Meta(ge=0.0, le=600_000.0, description="milliseconds from the request to its beginning")]
Unit = Literal["raw", "percent", "deg"]
Count = Annotated[int, Meta(ge=1, le=254, description="a count of a servo")]
MotionId = Annotated[int, Meta(ge=0, le=9999, description="the number of a motion in this API")]
Version = Annotated[
    int, Meta(ge=0, description="the revision that was looked at; refused (412) if it has changed since")
]
UNIT = Annotated[Unit, Meta(description="counts, percent of the range, or degrees of the joint")]


class MotorParams(Struct, kw_only=True):
    """The query of /motor."""

    id: Id | None = None
    pos: Position | None = None
    position: Annotated[float, Meta(description="the same as `pos`, which comes first")] | None = None
    torq: Torque | None = None
    torque: Annotated[float, Meta(description="the same as `torq`, which comes first")] | None = None
    unit: UNIT | None = None
    delay: DelayMs | None = None
    measured: Annotated[bool, Meta(description="whether what the servo reports is wanted too")] = False


class MultiParams(Struct, kw_only=True):
    """The query of /multimotor."""

    unit: UNIT | None = None


class MultiItem(Struct, kw_only=True):
    """One motor. `position`, `torque` and `toqr` are accepted too; other fields are echoed."""

    id: Id
    pos: Position
    torq: Torque = 0.0
    delay: DelayMs = 0.0


class MultiBody(Struct, kw_only=True):
    """The motors to move."""

    motors: Annotated[list[MultiItem], Meta(max_length=200)]


class FrameBody(Struct, kw_only=True, forbid_unknown_fields=True):
    """A key frame: angles of joints in radians by name, or counts of servos by number; other joints stay."""

    duration_s: DurationS
    positions: dict[str, JointRad] = {}
    counts: dict[str, Count] = {}


class MotionBody(Struct, kw_only=True, forbid_unknown_fields=True):
    """A motion as key frames; without `id` it gets the next free one from 100 on."""

    name: Name
    frames: Annotated[list[FrameBody], Meta(min_length=1, max_length=MAX_FRAMES)]
    id: MotionId | None = None
    button: Text = ""
    help: Text = ""
    version: Version | None = None


class MotorBody(Struct, kw_only=True, forbid_unknown_fields=True):
    """A motor of the displayed layer; `position` counts as its last commanded one before the first command."""

    name: Label
    lowest: Count = field(name="min")
    highest: Count = field(name="max")
    rest: Count = field(name="default")
    description: Text = ""
    inverted: bool = False
    position: Count | None = None
    version: Version | None = None


class NewMotorBody(MotorBody, kw_only=True, forbid_unknown_fields=True):
    """A new motor."""

    id: Annotated[int, Meta(ge=0, le=253)]


class MotorRow(Struct, frozen=True):
    """A stored motor."""

    id: int
    name: str
    description: str
    position: int
    min: int
    max: int
    default: int
    inverted: bool
    layer: str
    builtin: bool
    joint: str | None


class MotorRowAnswer(Struct, frozen=True):
    """A motor's row. `version` is the revision of all rows: quote it when you change this one."""

    data: MotorRow
    version: int


class Frame(Struct, frozen=True):
    """A key frame."""

    duration_s: float
    positions: dict[str, float]


class MotionRow(Struct, frozen=True):
    """A stored motion: played by the main board from a `slot`, or from here, by its key frames."""

    id: int
    name: str
    button: str
    motion: str
    help: str
    builtin: bool
    slot: int | None
    duration_s: float
    frames: list[Frame]


class MotionRowAnswer(Struct, frozen=True):
    """A motion's row. `version` is the revision of all rows: quote it when you change this one."""

    data: MotionRow
    version: int
