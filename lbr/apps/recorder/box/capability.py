"""The box as a process: once a round it takes the new messages, dates them, and passes them to the disk's thread."""

import fnmatch
import time
from collections import deque
from pathlib import Path
from typing import Any, Generic, TypeVar

from msgspec import Raw, Struct

from lbr import plugins
from lbr.apps.recorder.box.clock import Clock
from lbr.apps.recorder.box.disk import Bounds, BoxDisk, Chunk, Disk
from lbr.apps.recorder.box.inbox import ALL_ROWS, EVENT, LINES, STATUS, Arrival, Inbox, line
from lbr.apps.recorder.box.keeping import MARK, Keeping
from lbr.apps.recorder.box.kind import BoxSettings
from lbr.apps.recorder.box.logs import Logs
from lbr.apps.recorder.box.past import Past, read_history, read_then
from lbr.apps.recorder.messages import (
    BoxReply,
    BoxState,
    EndRecording,
    HistoryCommand,
    MarkCommand,
    RecordCommand,
    ThenCommand,
)
from lbr.apps.recorder.recording import chunks
from lbr.apps.recorder.recording.chunks import Channel, Channels
from lbr.apps.recorder.recording.decoding import read_or_none
from lbr.apps.recorder.recording.recorded import RecordedRows, RecordedStreams
from lbr.apps.recorder.recording.shelf import SUFFIX, Shelf
from lbr.bus import keys, stamp, wire
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.errors import BusError, DeviceError
from lbr.messages.system import Event

SEGMENT_S = 60.0
ASK_S = 2.0
AGAIN_S = 1.0
TELL_S = 5.0
FORMAT = "1"
TAPED = "@taped/"
EVENTS = 50
"""The newest events, which a new file repeats; the executive has as many to explain why something stands still."""
MB = 1_000_000
D = TypeVar("D", bound=Disk)


class _Answer(Struct):
    """The part of a console's answer that the box reads."""

    code: int
    text: str = ""
    data: Raw = Raw(b"null")


class _Revision(Struct):
    revision: int = 0


class Output(Generic[D]):
    """The part of a round that goes into one file, and the time of the next file."""

    def __init__(self, disk: D, segment_s: float | None) -> None:
        self.disk = disk
        self._segment_s = segment_s
        self._begun = -1e9
        self._parts: list[bytes] = []
        self._numbers: set[int] = set()
        self._bytes = self._first_ns = self._last_ns = 0

    def is_due(self, now: float) -> bool:
        """Return whether to begin another file."""
        return self.disk.broken or (self._segment_s is not None and now - self._begun >= self._segment_s)

    def add(self, number: int, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Add a message."""
        record = chunks.message(number, sequence, log_ns, publish_ns, data)
        self._parts.append(record)
        self._numbers.add(number)
        self._bytes += len(record)
        self._first_ns = min(self._first_ns or log_ns, log_ns)
        self._last_ns = max(self._last_ns, log_ns)

    def flush(self, channels: Channels, now: float, begin: dict[str, str] | None, declared: bytes) -> None:
        """Write the messages of this round. `declared` are the schemas new since the last round, or all in a new
        file."""
        if not self._parts:
            return
        head = [declared, channels.of(sorted(self._numbers))]
        chunk = Chunk([*head, *self._parts], len(self._parts), self._bytes, self._first_ns, self._last_ns, begin)
        if self.disk.put(chunk) and begin is not None:
            self._begun = now
            self.disk.broken = False
        self._parts, self._numbers = [], set()
        self._bytes = self._first_ns = self._last_ns = 0


class Box(Capability[BoxSettings]):
    """The black box. Raises DeviceError without a home to write to, or without a bus."""

    rate_hz = 1.25
    woken_by_streams = False

    def __init__(self, ctx: Context[BoxSettings]) -> None:
        super().__init__(ctx)
        self._channels = Channels()
        self._clock = Clock(stamp.boot_id(), time.monotonic_ns, time.time_ns)
        settings = ctx.settings
        self._keeping = Keeping(settings.before_s, settings.after_s)
        self._shelf = Shelf(Path(ctx.home), ctx.robot)
        self._past = Past(ctx, self._shelf)
        self._library = f"lbr {plugins.version()}"
        self._latest: dict[str, Arrival] = {}
        self._events: deque[Arrival] = deque(maxlen=EVENTS)
        self._streams: RecordedStreams | None = None
        self._rows = b""
        self._rows_revision = self._revision = -1
        self._schemas = b""
        self._questions: dict[str, wire.PendingQuery] = {}
        self._ask_at = self._picture_at = self._publish_at = self._room_at = 0.0
        self._published: BoxState | None = None
        self._warned = ""
        self._inbox: Inbox | None = None
        self._box_output: Output[BoxDisk] | None = None
        self._recording: Output[Disk] | None = None
        self._recording_until = self._recording_since = 0.0
        self._jumped = ""
        self._with_cameras = False

    def open(self) -> None:
        """Begin to record."""
        bus = getattr(self.ctx, "bus", None)
        if not self.ctx.home or bus is None:
            raise DeviceError("the black box writes where the robot's home is: leave it on the robot's own host")
        self._bus = bus
        self._inbox = Inbox(bus, self.ctx.robot, self.ctx.name, self._channels, self._clock)
        self._logs = Logs(Path(self.ctx.home) / "logs", self.ctx.robot)
        settings = self.ctx.settings
        self._bounds = Bounds(
            bytes=settings.mb * MB,
            seconds=settings.hours * 3600,
            kept_bytes=settings.kept_mb * MB,
            kept_seconds=settings.kept_days * 86400,
            free_bytes=settings.free_mb * MB,
        )
        self._box_output = Output(BoxDisk(self._shelf, self._bounds, self._library), SEGMENT_S)

    def step(self) -> None:
        """Record the messages of a round; other beats of the process only answer questions about the past."""
        self._past.step()
        if not self.ctx.on_tick or self._inbox is None or self._box_output is None:
            return
        now = self.ctx.clock()
        if jump_ns := self._clock.look():
            self._jumped = f"{jump_ns / 1e9:+.3f}"
            self.ctx.event("clock_jumped", f"the clock was set by {jump_ns / 1e9:+.1f} s; another file is begun")
            self._box_output.disk.broken = True
        self._box_output.disk.steady = self._clock.is_steady
        self._describe(now)
        self._round(now)
        if self._recording is not None and now >= self._recording_until:
            self._end("its time is over")
        elif self._recording is not None and now >= self._room_at:
            self._room_at = now + TELL_S
            if lacks := self._bounds.lacks_room(self._shelf.recordings_folder):
                self._end(lacks)
        self._publish_state(now)

    def command(self, call: Call) -> None:
        """Keep the files that led here, record on purpose, or answer a question about the past."""
        message = call.message
        if isinstance(message, MarkCommand):
            call.reply(self._mark(message.text or f"marked by {call.source}"))
        elif isinstance(message, RecordCommand):
            call.reply(self._record(message))
        elif isinstance(message, HistoryCommand):
            self._past.ask(call, read_history)
        elif isinstance(message, ThenCommand):
            self._past.ask(call, read_then)
        elif isinstance(message, EndRecording):
            call.reply(self._end("it was ended"))
        else:
            super().command(call)

    def close(self) -> None:
        """Write the remaining messages, and finish the files."""
        self._past.close()
        if self._inbox is None or self._box_output is None:
            return
        self._clock.look()
        self._round(self.ctx.clock())
        self._inbox.close()
        for output in self._outputs:
            output.disk.close()
        self._inbox = self._box_output = self._recording = None

    # -- one round -----------------------------------------------------------------------------------------------------

    @property
    def _outputs(self) -> list[Output[Any]]:
        """Return the file of the box, and that of a recording on purpose."""
        return [output for output in (self._box_output, self._recording) if output is not None]

    def _round(self, now: float) -> None:
        inbox, outputs = self._inbox, self._outputs
        assert inbox is not None
        begun = [each.is_due(now) for each in outputs]
        for each, begins in zip(outputs, begun, strict=True):
            if begins:
                self._repeat(each)
        hz = self.ctx.settings.cameras_hz
        if hz > 0 and now >= self._picture_at:
            self._picture_at = now + 1 / hz
            inbox.ask_for_pictures()
        for message in inbox.take():
            self._put(outputs, message)
        for writer, text in self._logs.take(self._streams.programs if self._streams is not None else ()):
            self._add_now(LINES, line(writer, text, self._clock.dated(self._clock.now_ns)), outputs)
        schemas = self._channels.schemas
        fresh, self._schemas = schemas[len(self._schemas) :], schemas
        for each, begins in zip(outputs, begun, strict=True):
            each.flush(self._channels, now, self._about() if begins else None, schemas if begins else fresh)

    def _put(self, outputs: list[Output[Any]], message: Arrival) -> None:
        if message.topic == STATUS and (status := read_or_none(message.data, _Revision)) is not None:
            self._revision = status.revision
        if message.topic == EVENT:
            self._take_event(message.data)
            self._events.append(message)
        elif not message.picture and not message.topic.startswith(TAPED):
            self._latest[message.topic] = message
        for output in outputs:
            if output is self._recording or not message.topic.startswith(TAPED):
                self._add(output, message)

    def _add_now(self, channel: Channel, data: bytes, outputs: list[Output[Any]]) -> None:
        """Add a message of this moment."""
        number, at_ns = self._channels.number(channel), self._clock.dated(self._clock.now_ns)
        for output in outputs:
            output.add(number, 0, at_ns, at_ns, data)

    def _add(self, output: Output[Any], arrival: Arrival) -> None:
        log_ns = self._clock.dated(arrival.mono_ns)
        output.add(arrival.number, arrival.sequence, log_ns, arrival.publish_ns, arrival.data)

    def _repeat(self, output: Output[Any]) -> None:
        """Begin a new file with the rows and the newest message of each stream, so that it stands by itself."""
        if self._rows:
            self._add_now(ALL_ROWS, self._rows, [output])
        for arrival in (*self._latest.values(), *self._events):
            self._add(output, arrival)

    def _about(self) -> dict[str, str]:
        facts = {
            "robot": self.ctx.robot,
            "lbr": plugins.version(),
            "format": FORMAT,
            "boot": stamp.boot_id(),
            "offset_ns": str(self._clock.offset_ns),
            "revision": str(self._rows_revision),
        }
        if self._jumped:
            facts["clock_jumped_s"], self._jumped = self._jumped, ""
        return facts

    def _take_event(self, payload: bytes) -> None:
        event = read_or_none(payload, Event)
        if event is None or event.subject == self.ctx.name:
            return
        keep = self._keeping.event(event, self.ctx.clock(), time.time_ns())
        if keep is not None and self._box_output is not None:
            self._box_output.disk.keep(keep)

    # -- the streams to record -----------------------------------------------------------------------------------------

    def _describe(self, now: float) -> None:
        """Ask for the streams and rows: at first, and after each new revision."""
        known = self._streams.revision if self._streams is not None else -1
        if not self._questions and now >= self._ask_at and (known < 0 or self._revision not in {-1, known}):
            self._ask_at = now + AGAIN_S
            try:
                self._questions = {name: self._question(f"/report/{name}") for name in ("streams", "rows")}
            except BusError:
                return
        if self._questions and all(one.done for one in self._questions.values()):
            answered, self._questions = self._questions, {}
            found = {name: _answer(one) for name, one in answered.items()}
            self._take_rows(found["rows"])
            self._take_streams(found["streams"])

    def _question(self, text: str) -> wire.PendingQuery:
        key = keys.console(self.ctx.robot, "view")
        return wire.PendingQuery(self._bus, key, text.encode(), timeout_s=ASK_S, source=self.ctx.name)

    def _take_rows(self, data: Raw | None) -> None:
        rows = read_or_none(data, RecordedRows)
        if rows is None or data is None or rows.revision == self._rows_revision:
            return
        self._rows, self._rows_revision = bytes(data), rows.revision
        self._add_now(ALL_ROWS, self._rows, self._outputs)

    def _take_streams(self, data: Raw | None) -> None:
        if (streams := read_or_none(data, RecordedStreams)) is not None:
            self._streams = streams
            self._follow()

    def _follow(self) -> None:
        if self._inbox is None or self._streams is None:
            return
        settings, recording = self.ctx.settings, self._recording
        everything = recording is not None

        def wanted(topic: str) -> bool:
            if any(fnmatch.fnmatchcase(topic, one) for one in settings.leave_out) and not everything:
                return False
            return everything or any(fnmatch.fnmatchcase(topic, one) for one in settings.streams)

        self._inbox.follow(self._streams.streams, wanted, pictures=recording is not None and self._with_cameras)

    # -- commands ------------------------------------------------------------------------------------------------------

    def _mark(self, text: str) -> BoxReply:
        if self._box_output is None:
            return BoxReply(accepted=False, reason="the black box does not write yet", code="not_ready")
        keep = self._keeping.incident(MARK, "", text, self.ctx.clock(), time.time_ns())
        assert keep is not None
        self.ctx.event(MARK, text)
        self._box_output.disk.keep(keep)
        settings = self.ctx.settings
        told = f"the last {settings.before_s:g} s are kept, and the next {settings.after_s:g} s, as {keep.name}"
        return BoxReply(accepted=True, reason=told, path=str(self._shelf.kept_folder / keep.name))

    def _record(self, asked: RecordCommand) -> BoxReply:
        if self._recording is not None:
            reason = f"{self._name(self._recording)} is being recorded: end it first (/record/end)"
            return BoxReply(accepted=False, reason=reason, code="busy")
        name = asked.name.removesuffix(SUFFIX) or time.strftime("%Y%m%d-%H%M%S")
        path = self._shelf.recordings_folder / f"{name}{SUFFIX}"
        try:
            self._shelf.make()
        except OSError as err:
            reason = f"{path} cannot be written ({err.strerror}): check the disk"
            return BoxReply(accepted=False, reason=reason, code="failed")
        if path.exists():
            return BoxReply(accepted=False, reason=f"{path} is there already: choose another name", code="bad_value")
        now = self.ctx.clock()
        self._recording = Output(Disk(lambda: path, self._library), None)
        self._recording_since = now
        self._recording_until = now + asked.seconds if asked.seconds else float("inf")
        self._refit(cameras=asked.cameras, lines=asked.lines)
        how = f"for {asked.seconds:g} s" if asked.seconds else "until it is ended (/record/end)"
        return BoxReply(accepted=True, reason=f"records {how}, into {path}", path=str(path))

    def _end(self, why: str) -> BoxReply:
        if self._recording is None:
            return BoxReply(accepted=False, reason="nothing is recorded on purpose now", code="not_possible")
        self._clock.look()
        self._round(self.ctx.clock())
        recording, self._recording = self._recording, None
        recording.disk.close(2.0)
        path = recording.disk.path
        self._refit(cameras=False, lines=False)
        lost = f"; {recording.disk.lost} messages are missing: {recording.disk.trouble}" if recording.disk.lost else ""
        text = f"recorded {recording.disk.size / MB:.1f} MB into {path}: {why}{lost}"
        self.ctx.event("recorded", text, level="warning" if lost else "info")
        return BoxReply(accepted=True, reason=text, path=str(path or ""))

    def _refit(self, *, cameras: bool, lines: bool) -> None:
        """Subscribe to what the recording needs, or needs no more, and publish the state."""
        self._with_cameras = cameras
        if self._inbox is not None:
            self._inbox.subscribe_lines(on=lines)
        self._follow()
        self._publish_at = 0.0
        self._publish_state(self.ctx.clock())

    # -- reports -------------------------------------------------------------------------------------------------------

    def _publish_state(self, now: float) -> None:
        output = self._box_output
        if output is None or self._inbox is None:
            return
        disk, recording = output.disk, self._recording
        trouble = disk.trouble or (recording.disk.trouble if recording is not None else "")
        if not trouble:
            self.ctx.ready()
        elif trouble != self._warned:
            self.ctx.warn(f"{trouble} ({disk.lost} messages so far)", "failed")
        self._warned = trouble
        if now < self._publish_at and self._published is not None and self._published.trouble == trouble:
            return
        self._publish_at = now + TELL_S
        self._published = BoxState(
            messages=disk.messages,
            lost=disk.lost + self._inbox.lost,
            disk_mb=round(disk.used_bytes / MB, 2),
            kept_mb=round(disk.kept_bytes / MB, 2),
            kept=disk.kept_count,
            recording=self._name(recording) if recording is not None else "",
            recording_s=round(now - self._recording_since, 1) if recording is not None else 0.0,
            recording_mb=round(recording.disk.size / MB, 2) if recording is not None else 0.0,
            trouble=trouble,
        )
        self.ctx.publish("state", self._published)

    def _name(self, output: Output[Any]) -> str:
        return output.disk.path.name if output.disk.path is not None else "a recording"


def _answer(query: wire.PendingQuery) -> Raw | None:
    found = read_or_none(query.replies[0].payload, _Answer) if query.replies else None
    return found.data if found is not None and found.code == 0 else None
