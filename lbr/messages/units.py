"""Number types with their unit, range and meaning; decoding refuses values out of range, NaN and infinity."""

from typing import Annotated, Any

from msgspec import Meta

from lbr.messages.shapes import NAME, NAME_OR_NONE


def basic(group: str, title: str, **more: Any) -> Meta:
    """Return the mark of a setting that people need first: its group on the page, and its title."""
    return Meta(title=title, extra_json_schema={"x-basic": group}, **more)


Power = Annotated[float, Meta(ge=0.0, le=1.0, description="fraction of full power")]
SignedPower = Annotated[float, Meta(ge=-1.0, le=1.0, description="forward positive")]
AngleDeg = Annotated[float, Meta(ge=-360.0, le=360.0, description="degrees clockwise from ahead")]
RangeCm = Annotated[float, Meta(ge=0.0, le=769.0, description="centimetres; 0 sets no range")]
IntervalS = Annotated[float, Meta(ge=0.0, le=3600.0, description="seconds; 0 sets no time")]
TtlS = Annotated[float, Meta(gt=0.0, le=1.0, description="seconds a command lives unless it is renewed")]
NAME_LETTERS = "[a-z][a-z0-9_]*"
NAME_PATTERN = f"^{NAME_LETTERS}$(?!\\n)"
"""For the whole text: `$` alone permits a line break at the end."""
NAME_OR_NONE_PATTERN = f"^$(?!\\n)|{NAME_PATTERN}"
Name = Annotated[str, Meta(pattern=NAME_PATTERN, max_length=40, extra={"shape": NAME})]
NameOrNone = Annotated[str, Meta(pattern=NAME_OR_NONE_PATTERN, max_length=40, extra={"shape": NAME_OR_NONE})]
"""A name, or empty for none."""
FILE_STEM_PATTERN = r"^$(?!\n)|^[A-Za-z0-9][A-Za-z0-9_.-]*$(?!\n)"
FileStem = Annotated[str, Meta(pattern=FILE_STEM_PATTERN, max_length=60)]
FILE_STEM = "letters, digits, '.', '_' and '-', the first a letter or a digit, 60 at most"
"""A `FileStem`, in words."""
StepNumber = Annotated[int, Meta(ge=1, le=10_000)]
"""The place of a row among those of one motion or dance, from 1."""
Vector = tuple[float, float, float]
"""Along x, y and z."""
Quaternion = tuple[float, float, float, float]
"""w, x, y, z; of length 1."""
TurnDeg = Annotated[float, Meta(ge=-360.0, le=360.0, description="degrees to turn, clockwise positive")]
HeadingDeg = Annotated[float, Meta(ge=0.0, le=360.0, description="degrees clockwise from true north")]
DistanceCm = Annotated[
    float,
    Meta(ge=0.0, le=10000.0, description="centimetres to travel; 0 sets no distance"),
    Meta(extra_json_schema={"x-typed-minimum": 1.0}),  # a typed distance is never 0
]
Fraction = Annotated[float, Meta(ge=0.0, le=1.0)]
SpeedMps = Annotated[float, Meta(ge=-10.0, le=10.0, description="metres a second")]
TurnRps = Annotated[float, Meta(ge=-20.0, le=20.0, description="radians a second, anticlockwise positive")]
