"""A bus in one process whose clock is stepped. It carries the same bytes, stamps and seals as Zenoh, always in the same
order. A message of one round arrives in the next, as late as on a busy machine."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from lbr.bus import stamp as stamps
from lbr.bus import wire
from lbr.bus.codec import Decoder
from lbr.bus.inflow import Inflow
from lbr.bus.stamp import Origin
from lbr.bus.wire import CommandQueue, RawMessage, Request
from lbr.messages.camera import JpegFrame

BEGAN_S = 100.0
"""Not zero, so that an unset time differs from it."""
MOMENT_NS = 1000
"""The time between two messages of one round, so that one is newer."""


class Memory:
    """The bus and its clock."""

    def __init__(self, now: float = BEGAN_S) -> None:
        self.names: set[str] = set()
        self.only_asked: set[str] = set()
        self.feeds: dict[str, list[MemoryFeed]] = {}
        self.servers: dict[str, CommandQueue] = {}
        self.latest: dict[str, RawMessage] = {}
        self.watchers: list[Callable[[str, bool], None]] = []
        self._now_ns = self._moment_ns = round(now * 1e9)
        self._sent: list[Callable[[], None]] = []
        self._questions: list[MemoryQuestion] = []
        self._counts: dict[str, int] = {}

    @property
    def now(self) -> float:
        """Monotonic seconds of this bus."""
        return self.clock()

    def clock(self) -> float:
        """Return `now`."""
        return self._now_ns / 1e9

    def moment(self) -> float:
        """Return a time in this round that is later than all before."""
        self._moment_ns = max(self._moment_ns + MOMENT_NS, round(self.now * 1e9))
        return self._moment_ns / 1e9

    def step(self, seconds: float) -> None:
        """Advance the time, and deliver what was sent."""
        self._now_ns += round(seconds * 1e9)
        sent, self._sent = self._sent, []
        for deliver in sent:
            deliver()
        now, waiting = self.now, self._questions
        self._questions = [one for one in waiting if not one.done and now < one.until]
        for late in waiting:
            if not late.done and now >= late.until:
                late.finish()

    def send(self, deliver: Callable[[], None]) -> None:
        """Call something at the beginning of the next round."""
        self._sent.append(deliver)

    def wait(self, question: "MemoryQuestion") -> None:
        """End a question when its time is over."""
        self._questions.append(question)

    def show(self, name: str, *, alive: bool = True) -> None:
        """Let a name be present, or no longer."""
        (self.names.add if alive else self.names.discard)(name)
        for changed in self.watchers:
            changed(name, alive)

    def listen(self, key: str, message: type[Any], hear: Callable[[Any], None]) -> None:
        """Call a listener with every message of a key, decoded."""
        decoder = Decoder(message)
        feed = MemoryFeed(self, key, 1, lambda: hear(decoder.decode(feed.take()[0].payload)))

    def publish(self, key: str, message: Any, source: str, *, sent_s: float | None = None, seal: bytes = b"") -> None:
        """Publish on a key as a sender that is not otherwise on this bus."""
        payload, count = wire.encode(message), self._counts.get(key, 0) + 1
        self._counts[key] = count
        self.carry(key, payload, stamps.make(source, count, payload, seal, sent_s=sent_s or self.moment()))

    def carry(self, key: str, payload: bytes, attachment: bytes) -> None:
        """Deliver bytes to all receivers of a key: streams, and commands that are put."""

        def deliver() -> None:
            message = RawMessage(key, payload, attachment, self.now)
            for feed in self.feeds.get(key, ()):
                feed.bring(message)
            if key in self.servers and key not in self.only_asked:
                self.servers[key].queue(MemoryRequest(self, key, payload, attachment, None))

        self.send(deliver)


class MemoryFeed:
    """The newest `depth` messages of a key."""

    def __init__(self, memory: Memory, key: str, depth: int, wake: Callable[[], None] | None) -> None:
        self._memory, self._key, self._wake = memory, key, wake
        self._slots: deque[RawMessage] = deque(maxlen=depth)
        memory.feeds.setdefault(key, []).append(self)

    def bring(self, message: RawMessage) -> None:
        """Keep a message, and wake the reader."""
        self._slots.append(message)
        if self._wake is not None:
            self._wake()

    def take(self) -> list[RawMessage]:
        """Return the messages since the last call, oldest first."""
        taken = list(self._slots)
        self._slots.clear()
        return taken

    def close(self) -> None:
        """Stop receiving."""
        if self in self._memory.feeds[self._key]:
            self._memory.feeds[self._key].remove(self)


class MemoryOutput:
    """A published stream; pictures count as watched while somebody receives them."""

    def __init__(self, memory: Memory, key: str, source: str, seal: bytes, *, follows: bool) -> None:
        self.key, self.count = key, 0
        self._memory, self._source, self._seal, self._follows = memory, source, seal, follows

    @property
    def watched(self) -> bool:
        """Return whether there is a subscriber, for an output that asks for it."""
        return not self._follows or bool(self._memory.feeds.get(self.key))

    def put(self, message: Any, *, taken_s: float | None = None, payload: bytes | None = None) -> bytes:
        """Publish, and return the stamp."""
        if payload is None:
            payload = message.data if isinstance(message, JpegFrame) else wire.encode(message)
        self.count += 1
        sent_s = self._memory.moment() if taken_s is None else taken_s
        attachment = stamps.make(self._source, self.count, payload, self._seal, sent_s=sent_s)
        self._memory.latest[self.key] = RawMessage(self.key, payload, attachment, self._memory.now)
        self._memory.carry(self.key, payload, attachment)
        return attachment

    def forget(self) -> None:
        """Stop answering `get` with the last message."""
        self._memory.latest.pop(self.key, None)


class MemoryRequest(Request):
    """A command that waits for its answer."""

    def __init__(
        self, memory: Memory, key: str, payload: bytes, attachment: bytes, question: "MemoryQuestion | None"
    ) -> None:
        super().__init__(key, payload, attachment, None)
        self.arrived = memory.now
        self._memory, self._question = memory, question

    @property
    def answerable(self) -> bool:
        """Return whether the sender waits for an answer."""
        return self._question is not None

    def forward_reply(self, payload: bytes, attachment: bytes) -> None:
        """Answer, once."""
        question, self._question = self._question, None
        if question is not None:
            self._memory.send(lambda: question.bring(RawMessage(self.key, payload, attachment, self._memory.now)))


class MemoryQuestion:
    """A query under way; without a target it ends at once."""

    def __init__(
        self, memory: Memory, key: str, payload: bytes, attachment: bytes, timeout_s: float, wake: Callable[[], None]
    ) -> None:
        self.key, self.done, self.until = key, False, memory.now + timeout_s
        self.replies: list[RawMessage] = []
        self._wake = wake

        def deliver() -> None:
            server = memory.servers.get(key)
            if server is None:
                self.finish()
            else:
                server.queue(MemoryRequest(memory, key, payload, attachment, self))

        memory.send(deliver)
        memory.wait(self)

    def bring(self, reply: RawMessage) -> None:
        """Accept the answer, unless it is too late."""
        if not self.done:
            self.replies.append(reply)
            self.finish()

    def finish(self) -> None:
        """End, with an answer or without."""
        self.done = True
        self._wake()


@dataclass
class MemoryPresence:
    """The names that are present."""

    names: set[str]


class MemoryTransport:
    """One participant's part of a bus in memory, by the bus's clock unless it has a `clock` of its own."""

    def __init__(self, memory: Memory, clock: Callable[[], float] | None = None) -> None:
        self.memory, self.clock = memory, clock or memory.clock
        self._close: list[Callable[[], object]] = []

    def publisher(
        self,
        key: str,
        source: str,
        *,
        seal: bytes = b"",
        pictures: bool = False,
        watching: Callable[[], None] | None = None,
    ) -> MemoryOutput:
        """Publish a stream."""
        del pictures
        output = MemoryOutput(self.memory, key, source, seal, follows=watching is not None)
        self._close.append(output.forget)
        return output

    def subscribe(self, key: str, *, depth: int, wake: Callable[[], None] | None) -> MemoryFeed:
        """Receive a stream."""
        feed = MemoryFeed(self.memory, key, depth, wake)
        self._close.append(feed.close)
        return feed

    def serve(
        self, key: str, wake: Callable[[], None], *, source: str, puts: bool = True, inflow: Inflow | None = None
    ) -> CommandQueue:
        """Answer commands."""
        server = self.memory.servers[key] = CommandQueue(key, wake, source, inflow)
        if not puts:
            self.memory.only_asked.add(key)
        self._close.append(lambda: self.memory.servers.pop(key, None))
        return server

    def query(
        self,
        key: str,
        payload: bytes,
        *,
        timeout_s: float,
        source: str,
        wake: Callable[[], None] = lambda: None,
        origin: Origin | None = None,
    ) -> MemoryQuestion:
        """Ask one key."""
        attachment = stamps.make(source, 0, payload, sent_s=self.memory.moment(), origin=origin)
        return MemoryQuestion(self.memory, key, payload, attachment, timeout_s, wake)

    def newest(self, keys: Iterable[str], *, source: str, timeout_s: float) -> list[RawMessage]:
        """Return the latest values of streams."""
        del source, timeout_s
        return [self.memory.latest[key] for key in keys if key in self.memory.latest]

    def put(self, key: str, message: Any, *, source: str) -> None:
        """Publish once."""
        self.memory.publish(key, message, source)

    def document(self, key: str, make: Callable[[], Mapping[str, Any]]) -> None:
        """Do nothing: nobody asks for schemas here."""

    def presence(self, robot: str, changed: Callable[[str, bool], None]) -> MemoryPresence:
        """Watch who is present."""
        del robot
        self.memory.watchers.append(changed)
        self._close.append(lambda: self.memory.watchers.remove(changed))
        return MemoryPresence(self.memory.names)

    def alive(self, robot: str, name: str) -> None:
        """Show that a capability is present."""
        del robot
        self.memory.show(name)
        self._close.append(lambda: self.memory.show(name, alive=False))

    def close(self) -> None:
        """Withdraw all declarations."""
        closing, self._close = self._close, []
        for take_back in reversed(closing):
            take_back()
