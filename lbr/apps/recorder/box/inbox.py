"""The messages from the bus: the bus library queues them, and the box takes all of them once a round."""

import functools
from collections.abc import Callable, Collection, Iterator
from typing import NamedTuple

import msgspec
from msgspec import Struct

from lbr.apps.recorder.box.clock import MOST_NS, Clock
from lbr.apps.recorder.recording.chunks import PICTURES, Channel, Channels
from lbr.apps.recorder.recording.recorded import RecordedStream
from lbr.bus import keys, pictures, wire
from lbr.bus.session import Session
from lbr.errors import BusError
from lbr.messages.schema import flat_schema
from lbr.messages.system import Event, Status
from lbr.messages.taped import Taped
from lbr.messages.unreadable import UNREADABLE

DEPTH = 512
"""The queue of a stream: five seconds at 100 Hz, in case the machine is too busy to take messages."""
EVENTS_DEPTH = 2048
PICTURES_DEPTH = 64
TAPED_DEPTH = 4096
PICTURE_S = 2.0
STATUS, EVENT, ROWS, LOG = "@status", "@event", "@rows", "@log"
_NUMBER, _TEXT = {"type": "integer"}, {"type": "string"}


def _schema(title: str, **fields: object) -> bytes:
    """Return a schema that viewers of recordings know; its types are not referred to, which some do not follow."""
    time = {"type": "object", "properties": {"sec": _NUMBER, "nsec": _NUMBER}}
    return msgspec.json.encode({"title": title, "type": "object", "properties": {"timestamp": time, **fields}})


PICTURE_SCHEMA = _schema(PICTURES, frame_id=_TEXT, data={**_TEXT, "contentEncoding": "base64"}, format=_TEXT)
LINES = Channel(LOG, "json", "foxglove.Log", _schema("foxglove.Log", level=_NUMBER, message=_TEXT, name=_TEXT))
ALL_ROWS = Channel(ROWS, "json", "Rows", b'{"type":"object"}')


class _Stamp(Struct, gc=False):
    """The fields of a stamp that date a message."""

    seq: int = 0
    mono_ns: int = 0
    wall_ns: int = 0
    boot: str = ""


_stamps = msgspec.json.Decoder(_Stamp)
_NO_STAMP = _Stamp()


class Arrival(NamedTuple):
    """A message as it is recorded; `mono_ns` is the time it was sent, by this machine's clock."""

    topic: str
    number: int
    sequence: int
    mono_ns: int
    publish_ns: int
    data: bytes
    picture: bool = False


class _Feed(Struct):
    """A subscribed stream. Gaps after the number `last` are losses; it stays 0 for many senders with own numbers."""

    subscription: wire.PolledSubscription
    topic: str
    number: int
    picture: bool
    last: int = 0


class Inbox:
    """Receives the streams of a robot, its events and its status. One thread uses it."""

    def __init__(self, bus: Session, robot: str, source: str, channels: Channels, clock: Clock) -> None:
        self.lost = 0
        self._bus = bus
        self._robot = robot
        self._source = source
        self._channels = channels
        self._clock = clock
        self._feeds: dict[str, _Feed] = {}
        self._taped: wire.PolledSubscription | None = None
        self._cameras: dict[str, RecordedStream] = {}
        self._asked: list[tuple[RecordedStream, wire.PendingQuery]] = []
        self._seen: dict[str, tuple[int, int]] = {}
        self._subscribe(keys.event(robot), EVENT, _channel(EVENT, Event), EVENTS_DEPTH)
        self._subscribe(keys.status(robot), STATUS, _channel(STATUS, Status), 64)

    def follow(self, streams: Collection[RecordedStream], wanted: Callable[[str], bool], *, pictures: bool) -> None:
        """Subscribe to these streams alone; to camera streams only with `pictures`."""
        wanted_streams = {stream.key: stream for stream in streams if wanted(self._topic(stream.key))}
        self._cameras = {key: stream for key, stream in wanted_streams.items() if stream.picture}
        plain = {key: stream for key, stream in wanted_streams.items() if pictures or not stream.picture}
        system = {keys.event(self._robot), keys.status(self._robot)}
        for key in [key for key in self._feeds if key not in plain and key not in system]:
            self._feeds.pop(key).subscription.close()
        for key, stream in plain.items():
            channel = self._channel_of(stream)
            number = self._channels.number(channel)
            if key in self._feeds:
                self._feeds[key].number = number
            else:
                self._subscribe(
                    key, channel.topic, channel, PICTURES_DEPTH if stream.picture else DEPTH, picture=stream.picture
                )

    def subscribe_lines(self, *, on: bool) -> None:
        """Subscribe to every capability's device bytes and commands, or end that. They are published only while
        somebody does."""
        if on and self._taped is None:
            self._taped = wire.PolledSubscription(self._bus, keys.taped(self._robot, "*"), depth=TAPED_DEPTH)
        elif not on and self._taped is not None:
            self._taped.close()
            self._taped = None

    def ask_for_pictures(self) -> None:
        """Query each camera for its newest picture; a later `take` yields it."""
        for key, stream in self._cameras.items():
            if key not in self._feeds:
                try:
                    query = wire.PendingQuery(self._bus, key, b"", timeout_s=PICTURE_S, source=self._source)
                except BusError:
                    continue
                self._asked.append((stream, query))

    def take(self) -> Iterator[Arrival]:
        """Yield the messages since the last call, stream by stream."""
        for feed in self._feeds.values():
            for raw in feed.subscription.take():
                stamp = _stamp_of(raw.attachment)
                if 0 < feed.last < stamp.seq - 1:
                    self.lost += stamp.seq - feed.last - 1
                feed.last = stamp.seq if not feed.topic.startswith("@") else 0
                yield self._dated(feed.topic, feed.number, stamp, raw.payload, picture=feed.picture)
        for raw in self._taped.take() if self._taped is not None else ():
            topic = self._topic(raw.key)
            number = self._channels.number(_channel(topic, Taped))
            yield self._dated(topic, number, _stamp_of(raw.attachment), raw.payload, picture=False)
        yield from self._pictures()

    def close(self) -> None:
        """End all subscriptions."""
        self.subscribe_lines(on=False)
        for feed in self._feeds.values():
            feed.subscription.close()

    def _pictures(self) -> Iterator[Arrival]:
        waiting = []
        for stream, query in self._asked:
            if not query.done:
                waiting.append((stream, query))
            for raw in query.replies[:1] if query.done else ():
                stamp = _stamp_of(raw.attachment)
                if self._seen.get(stream.key) != (stamp.seq, stamp.mono_ns):
                    self._seen[stream.key] = stamp.seq, stamp.mono_ns
                    channel = self._channel_of(stream)
                    yield self._dated(channel.topic, self._channels.number(channel), stamp, raw.payload, picture=True)
        self._asked = waiting

    def _dated(self, topic: str, number: int, stamp: _Stamp, payload: bytes, *, picture: bool) -> Arrival:
        mono_ns = self._clock.sent_ns(stamp.boot, stamp.mono_ns)
        publish_ns = stamp.wall_ns if 0 < stamp.wall_ns < MOST_NS else self._clock.dated(mono_ns)
        if picture:
            payload = image(payload, topic.partition("/")[0], self._clock.dated(mono_ns))
        return Arrival(topic, number, stamp.seq, mono_ns, publish_ns, payload, picture)

    def _subscribe(self, key: str, topic: str, channel: Channel, depth: int, *, picture: bool = False) -> None:
        subscription = wire.PolledSubscription(self._bus, key, depth=depth)
        self._feeds[key] = _Feed(subscription, topic, self._channels.number(channel), picture)

    def _channel_of(self, stream: RecordedStream) -> Channel:
        topic = self._topic(stream.key)
        if stream.picture:
            return Channel(topic, "json", PICTURES, PICTURE_SCHEMA)
        schema = msgspec.json.decode(stream.schema) if bytes(stream.schema) else None
        if not isinstance(schema, dict) or not schema:
            return Channel(topic, "json")
        return Channel(topic, "json", stream.message, flat_schema(schema))

    def _topic(self, key: str) -> str:
        return key.removeprefix(f"{self._robot}/")


def image(data: bytes, frame: str, at_ns: int) -> bytes:
    """Return a picture in the form that viewers of recordings read."""
    form = "jpeg" if pictures.is_whole(data) else "broken"
    return _at(at_ns, frame_id=frame, format=form, data=data)  # bytes become base64


def line(writer: str, text: str, at_ns: int) -> bytes:
    """Return a log line in the form that viewers of recordings read."""
    return _at(at_ns, level=2, message=text, name=writer)


def _at(at_ns: int, **fields: object) -> bytes:
    sec, nsec = divmod(at_ns, 1_000_000_000)
    return msgspec.json.encode({"timestamp": {"sec": sec, "nsec": nsec}, **fields})


def _stamp_of(attachment: bytes) -> _Stamp:
    try:
        return _stamps.decode(attachment)
    except UNREADABLE:
        return _NO_STAMP


@functools.cache
def _channel(topic: str, message: type[object]) -> Channel:
    return Channel(topic, "json", message.__name__, flat_schema(msgspec.json.schema(message)))
