"""Messages on `box/*`: the robot's black box."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.units import FileStem

Text = Annotated[str, Meta(max_length=200)]
Field = Annotated[
    str, Meta(max_length=160, pattern=r"^[^./]+/[^./]+\..+$(?!\n)", description="such as battery/state.voltage_v")
]
WallNs = Annotated[int, Meta(ge=0, description="since 1970, by the robot's clock")]


class MarkCommand(Struct, frozen=True, kw_only=True):
    """Keep the records up to now, and of a while after; `text`: the observation."""

    text: Text = ""


class RecordCommand(Struct, frozen=True, kw_only=True):
    """Record into a separate file, for `seconds`; 0: until it is ended. `cameras`: with every picture. `lines`: with
    the bytes of the devices' lines, all commands and answers. `name`: of the file; else made of the time."""

    seconds: Annotated[float, Meta(ge=0.0, le=86400.0)] = 0.0
    cameras: bool = False
    lines: bool = False
    name: FileStem = ""


class EndRecording(Struct, frozen=True, kw_only=True):
    """End the recording that was begun on purpose."""


class HistoryCommand(Struct, frozen=True, kw_only=True):
    """Return numbers of streams from the black box, at `points` times at most."""

    fields: Annotated[tuple[Field, ...], Meta(min_length=1, max_length=40)]
    from_ns: WallNs
    to_ns: WallNs
    points: Annotated[int, Meta(ge=2, le=600)] = 240


class HistoryReply(Struct, frozen=True, kw_only=True):
    """The times in milliseconds since 1970, and each field's number then, or null."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    at_ms: list[int] = []
    values: dict[str, list[float | None]] = {}


class ThenCommand(Struct, frozen=True, kw_only=True):
    """Explain why a part, or without `part` the whole robot, stood still at a moment."""

    at_ns: WallNs
    part: Text = ""


class ThenReply(Struct, frozen=True, kw_only=True):
    """The answer; `late_s`: the time from the last record to that moment."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    state: str = ""
    text: str = ""
    late_s: float = 0.0


class BoxReply(Struct, frozen=True, kw_only=True):
    """The result; `path`: the file, or the folder of a kept incident."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    path: str = ""


class BoxState(Struct, frozen=True, kw_only=True):
    """The state of the box: its writes since it started, its losses, and its files.

    `lost`: messages not written, because the disk is slow or full or they are too many. `disk_mb`: the box's own files;
    `kept_mb`: those of the `kept` incidents. `recording`: the file of a recording on purpose, of `recording_mb` and
    `recording_s` so far. `trouble`: the problem, in one line.
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
