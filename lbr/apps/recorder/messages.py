"""Messages on `box/*`: the robot's black box."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.units import FileStem

Text = Annotated[str, Meta(max_length=200)]
Field = Annotated[
    str, Meta(max_length=160, pattern=r"^[^./]+/[^./]+\..+$(?!\n)", description="such as battery/state.voltage_v")
]
WallNs = Annotated[int, Meta(ge=0, description="nanoseconds since 1970, by the robot's clock")]


class MarkCommand(Struct, frozen=True, kw_only=True):
    """Keep what led here, and a while after: something was noticed, which `text` says."""

    text: Text = ""


class RecordCommand(Struct, frozen=True, kw_only=True):
    """Record on purpose, into a file of its own: `seconds` long, or until it is ended (0).

    `cameras`: every picture that they take. `lines`: the bytes of the devices' lines, and all commands with their
    answers, too. `name` is the file's; without one it is made of the time.
    """

    seconds: Annotated[float, Meta(ge=0.0, le=86400.0)] = 0.0
    cameras: bool = False
    lines: bool = False
    name: FileStem = ""


class EndRecording(Struct, frozen=True, kw_only=True):
    """End the recording that was begun on purpose."""


class HistoryCommand(Struct, frozen=True, kw_only=True):
    """Return numbers of streams out of the black box, at `points` times at most between two of them."""

    fields: Annotated[tuple[Field, ...], Meta(min_length=1, max_length=40)]
    from_ns: WallNs
    to_ns: WallNs
    points: Annotated[int, Meta(ge=2, le=600)] = 240


class HistoryReply(Struct, frozen=True, kw_only=True):
    """The times in milliseconds since 1970, and for each field a number at each of them, or null."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    at_ms: list[int] = []
    values: dict[str, list[float | None]] = {}


class ThenCommand(Struct, frozen=True, kw_only=True):
    """Explain why something stood still at a moment, as `why` would have then; without `part` of the whole robot."""

    at_ns: WallNs
    part: Text = ""


class ThenReply(Struct, frozen=True, kw_only=True):
    """The answer of then; `late_s` is how long before the moment anything was recorded last."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    state: str = ""
    text: str = ""
    late_s: float = 0.0


class BoxReply(Struct, frozen=True, kw_only=True):
    """The result; `path` is the file, or the folder of what is kept."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    path: str = ""


class BoxState(Struct, frozen=True, kw_only=True):
    """The state of the box: its writes since it started, its losses, and its files.

    `messages` were written, `lost` could not be: the disk was slow or full, or they came faster than they were taken.
    `disk_mb` is the size of the box's own files, `kept_mb` of those kept for longer, `kept` how many times something
    was. `recording` is the file of a recording on purpose, else empty, `recording_s` for how long it goes on and
    `recording_mb` how large it is. `trouble` is the problem, in one line.
    """

    messages: int = 0
    lost: int = 0
    disk_mb: float = 0.0
    kept_mb: float = 0.0
    kept: int = 0
    recording: str = ""
    recording_s: float = 0.0
    recording_mb: float = 0.0
    trouble: str = ""
