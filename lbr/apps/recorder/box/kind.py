"""The kind `box`: its settings, ports and words."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.apps.recorder.messages import (
    BoxReply,
    BoxState,
    EndRecording,
    HistoryCommand,
    HistoryReply,
    MarkCommand,
    RecordCommand,
    ThenCommand,
    ThenReply,
)
from lbr.capability.kind import Command, Kind, Rights
from lbr.capability.word import Word

Pattern = Annotated[str, Meta(min_length=1, max_length=80, description="topics, * for any letters: motors/*, */state")]


class BoxSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `box`."""

    mb: Annotated[int, Meta(ge=4, le=1_000_000, description="megabytes of its own files; the oldest go")] = 500
    hours: Annotated[float, Meta(gt=0.0, le=87_600.0, description="for how long they stay")] = 24.0
    kept_mb: Annotated[int, Meta(ge=0, le=1_000_000, description="megabytes for what led to incidents")] = 500
    kept_days: Annotated[float, Meta(gt=0.0, le=3650.0, description="for how long that stays")] = 30.0
    before_s: Annotated[float, Meta(ge=5.0, le=3600.0, description="how much before an incident is kept")] = 60.0
    after_s: Annotated[float, Meta(ge=1.0, le=3600.0, description="and how much after it")] = 20.0
    streams: Annotated[tuple[Pattern, ...], Meta(max_length=64, description="which streams, by their topics")] = ("*",)
    leave_out: Annotated[tuple[Pattern, ...], Meta(max_length=64, description="which of them not")] = ()
    cameras_hz: Annotated[float, Meta(ge=0.0, le=1.0, description="pictures a second of each camera; 0: none")] = 0.2
    free_mb: Annotated[int, Meta(ge=0, le=1_000_000, description="megabytes of disk left to others, 5 % at most")] = 200


KIND = Kind(
    name="box",
    summary="the black box: always records all messages of the bus, and keeps those before an incident",
    family="app",
    entry="lbr.apps.recorder.box.start:Box",
    settings=BoxSettings,
    outputs={"state": BoxState},
    commands={
        "mark": MarkCommand,
        "record": RecordCommand,
        "end": EndRecording,
        "history": Command(HistoryCommand, role="view"),
        "then": Command(ThenCommand, role="view"),
    },
    replies={
        **dict.fromkeys(("mark", "record", "end"), BoxReply),
        "history": HistoryReply,
        "then": ThenReply,
    },
    rights=Rights(records=True),
    words=(
        Word("mark", "mark", "Keep what led here, and a while after, in the black box", role="operate"),
        Word("/mark/{text...}", "mark", "The same, and say what was noticed, such as /mark/it limps", role="operate"),
        Word(
            "/record/{seconds}", "record", "Record on purpose for so many seconds; 0: until /record/end", role="operate"
        ),
        Word("/record/end", "end", "End the recording that was begun on purpose", role="operate"),
    ),
)
