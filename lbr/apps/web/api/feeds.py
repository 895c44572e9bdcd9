"""The newest message of each stream, subscribed once for all viewers; on the server's thread alone.

Messages wait in the bus library until a viewer's next frame, and are passed on as the bytes received.
"""

import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice

import msgspec

from lbr.apps.web.api.catalog import EVENT
from lbr.apps.web.api.robot_bus import RobotBus
from lbr.bus import stamp
from lbr.bus.wire import PendingQuery, PolledSubscription, RawMessage
from lbr.errors import BusError
from lbr.messages.unreadable import UNREADABLE

KEPT_S = 5.0
"""The time for which a stream without viewers stays subscribed, so that a reloaded page finds its newest message."""
LOOK_S = 0.004
FIRST_S = 1.0
MOST_EVENTS = 128
LARGEST_SHOWN = 256 * 1024
_whole = msgspec.json.Decoder(msgspec.Raw)


@dataclass(frozen=True, slots=True)
class Sample:
    """A message in its original JSON; `number` counts a stream's messages."""

    text: bytes
    sent_s: float
    number: int


@dataclass(slots=True)
class _Heard:
    feed: PolledSubscription
    first: PendingQuery | None
    unwanted_s: float | None = None
    looked_s: float = 0.0
    newest: Sample | None = None
    recent: deque[Sample] = field(default_factory=deque)
    count: int = 0


class Feeds:
    """The streams that viewers want; `key` converts a name below the robot's to its bus key."""

    def __init__(
        self, bus: RobotBus, key: Callable[[str], str], source: str, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._bus = bus
        self._key = key
        self._source = source
        self._clock = clock
        self._heard: dict[str, _Heard] = {}
        self._wanted: dict[object, frozenset[str]] = {}

    def want(self, viewer: object, names: Iterable[str]) -> None:
        """Replace a viewer's streams."""
        self._wanted[viewer] = frozenset(names)
        self.tidy()

    def leave(self, viewer: object) -> None:
        """Forget a viewer."""
        self._wanted.pop(viewer, None)
        self.tidy()

    def newest(self, name: str) -> Sample | None:
        """Return the newest message of a wanted stream, or None before the first."""
        feed = self._heard.get(name)
        if feed is None:
            return None
        self._look(feed)
        return feed.newest

    def events(self, after: int) -> tuple[Sample, ...]:
        """Return the newest events with numbers above `after`, oldest first."""
        feed = self._heard.get(EVENT)
        if feed is None:
            return ()
        self._look(feed)
        count = feed.count - after
        return tuple(islice(feed.recent, max(0, len(feed.recent) - count), None)) if count > 0 else ()

    @property
    def last_event(self) -> int:
        """Return the number of the newest event."""
        feed = self._heard.get(EVENT)
        return feed.count if feed is not None else 0

    def close(self) -> None:
        """End all subscriptions."""
        self._wanted.clear()
        for feed in self._heard.values():
            feed.feed.close()
        self._heard.clear()

    def tidy(self) -> None:
        """Subscribe to the wanted streams; end the subscriptions without viewers for `KEPT_S`."""
        now, wanted = self._clock(), frozenset().union(*self._wanted.values())
        for name in wanted - self._heard.keys():
            self._heard[name] = self._begun(name)
        for name, feed in list(self._heard.items()):
            if name in wanted:
                feed.unwanted_s = None
            elif feed.unwanted_s is None:
                feed.unwanted_s = now
            elif now - feed.unwanted_s > KEPT_S:
                feed.feed.close()
                del self._heard[name]

    def _begun(self, name: str) -> _Heard:
        feed = self._bus.hear(self._key(name), depth=MOST_EVENTS if name == EVENT else 1)
        first = None
        with suppress(BusError):  # then the first message is the next one published
            first = (
                self._bus.ask(self._key(name), b"", source=self._source, timeout_s=FIRST_S) if name != EVENT else None
            )
        return _Heard(feed, first, recent=deque(maxlen=MOST_EVENTS if name == EVENT else 1))

    def _look(self, feed: _Heard) -> None:
        now = self._clock()
        if now - feed.looked_s < LOOK_S:
            return
        feed.looked_s = now
        came = feed.feed.take()
        if feed.first is not None and (feed.first.replies or feed.first.done):
            came = [*feed.first.replies[:1], *came] if feed.newest is None else came
            feed.first = None
        for raw in came:
            if (sample := sample_of(raw, feed.count + 1)) is not None:
                feed.count, feed.newest = sample.number, sample
                feed.recent.append(sample)


def sample_of(raw: RawMessage, number: int = 0) -> Sample | None:
    """Return a message as a sample; None if it is not JSON, or is too large for a viewer's line."""
    if len(raw.payload) > LARGEST_SHOWN:
        return None
    try:
        _whole.decode(raw.payload)
        raw.payload.decode()
    except UNREADABLE:
        return None
    return Sample(raw.payload, stamp.sent_s(stamp.read(raw.attachment), raw.arrived), number)
