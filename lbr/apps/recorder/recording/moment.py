"""A robot at a past moment: its rows, its status, the newest message of each stream, and the events until then."""

from pathlib import Path

from msgspec import Struct

from lbr.apps.recorder.recording import selection
from lbr.apps.recorder.recording.chunks import Message
from lbr.apps.recorder.recording.recorded import RecordedRows
from lbr.errors import InputError
from lbr.messages.system import Event, Status

MOST_EVENTS = 50
SILENT_S = 3.0
"""A robot that runs publishes something each second."""
_SYSTEM = ("@rows", "@status", "@event", "@log")


class Moment(Struct, frozen=True, kw_only=True):
    """The state at a moment; `messages` are the newest by topic with their ages, `events` oldest first.

    `late_s` is the time since the last record before the moment; a large one means the box was off.
    """

    at_ns: int
    late_s: float
    rows: RecordedRows | None = None
    status: Status | None = None
    messages: dict[str, tuple[dict[str, object], float]] = {}
    events: tuple[Event, ...] = ()


def moment(files: tuple[Path, ...], at_ns: int) -> Moment:
    """Read a moment from files, oldest first; raise InputError if nothing was recorded until then."""
    path = selection.file_at(files, at_ns)
    if path is None:
        raise InputError("nothing was recorded until then ('lbr box list' shows from when on)")
    newest: dict[str, Message] = {}
    events: list[Event] = []
    for message in selection.messages([path], 0, at_ns):
        if message.topic == selection.EVENT:
            events += [event for event in [message.read(Event)] if event is not None]
        newest[message.topic] = message
    last_ns = max((message.log_ns for message in newest.values()), default=0)
    if not last_ns:
        raise InputError("nothing that can be read was recorded until then")
    return Moment(
        at_ns=at_ns,
        late_s=max(0.0, (at_ns - last_ns) / 1e9),
        rows=newest["@rows"].read(RecordedRows) if "@rows" in newest else None,
        status=newest["@status"].read(Status) if "@status" in newest else None,
        messages={
            topic: (value, max(0.0, (at_ns - message.log_ns) / 1e9))
            for topic, message in newest.items()
            if topic not in _SYSTEM and (value := message.read(dict[str, object])) is not None
        },
        events=tuple(events[-MOST_EVENTS:]),
    )
