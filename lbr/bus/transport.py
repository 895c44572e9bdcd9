"""Below a capability's context: a clock, streams, commands and presence; Zenoh's, or memory's (`lbr.bus.memory`)."""

import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

from lbr.bus import session, wire
from lbr.bus.inflow import Inflow
from lbr.bus.stamp import Origin
from lbr.bus.wire import CommandQueue, RawMessage


class Output(Protocol):
    """A stream that is published, with a `get` of its latest value."""

    count: int

    @property
    def watched(self) -> bool:
        """The existence of a subscriber; of an output that does not follow that, true."""

    def put(self, message: Any, *, taken_s: float | None = None, payload: bytes | None = None) -> bytes:
        """Publish, and return the stamp; `payload` is the message as bytes, where those are known."""

    def forget(self) -> None:
        """Answer no `get` any more with what was published."""


class Feed(Protocol):
    """A stream that is received."""

    def take(self) -> list[RawMessage]:
        """Return what arrived since the last call, oldest first."""

    def close(self) -> None:
        """Stop receiving."""


class Question(Protocol):
    """A query under way."""

    done: bool
    replies: list[RawMessage]


class Present(Protocol):
    """The names of the capabilities that are there."""

    names: set[str]


class Transport(Protocol):
    """One participant's part of a bus; closing it takes back all that it has declared."""

    def clock(self) -> float:
        """Monotonic seconds."""

    def publisher(
        self,
        key: str,
        source: str,
        *,
        seal: bytes = b"",
        pictures: bool = False,
        watching: Callable[[], None] | None = None,
    ) -> Output:
        """Publish a stream; `watching` is called when `watched` has changed."""

    def subscribe(self, key: str, *, depth: int, wake: Callable[[], None] | None) -> Feed:
        """Receive the newest `depth` messages of a stream; without `wake` they wait until they are taken."""

    def serve(
        self, key: str, wake: Callable[[], None], *, source: str, puts: bool = True, inflow: Inflow | None = None
    ) -> CommandQueue:
        """Answer commands."""

    def query(
        self,
        key: str,
        payload: bytes,
        *,
        timeout_s: float,
        source: str,
        wake: Callable[[], None],
        origin: Origin | None = None,
    ) -> Question:
        """Ask one key."""

    def newest(self, keys: Iterable[str], *, source: str, timeout_s: float) -> list[RawMessage]:
        """Return the latest values of streams, as far as they come in time."""

    def put(self, key: str, message: Any, *, source: str) -> None:
        """Publish once, ahead of all streams. BusError: it was not sent."""

    def document(self, key: str, make: Callable[[], Mapping[str, Any]]) -> object:
        """Answer every query of a key with the same document."""

    def presence(self, robot: str, changed: Callable[[str, bool], None]) -> Present:
        """Watch who is there."""

    def alive(self, robot: str, name: str) -> object:
        """Show that a capability is there."""

    def close(self) -> None:
        """Leave the bus."""


class ZenohTransport:
    """A part of the bus by a session of Zenoh, which it closes at the end."""

    def __init__(self, opened: session.Session) -> None:
        self.session = opened
        self.clock = time.monotonic

    def publisher(
        self,
        key: str,
        source: str,
        *,
        seal: bytes = b"",
        pictures: bool = False,
        watching: Callable[[], None] | None = None,
    ) -> Output:
        """Publish a stream."""
        return wire.Publisher(self.session, key, source, seal=seal, pictures=pictures, watching=watching)

    def subscribe(self, key: str, *, depth: int, wake: Callable[[], None] | None) -> Feed:
        """Receive a stream; one that wakes no loop waits within Zenoh."""
        if wake is None:
            return wire.PolledSubscription(self.session, key, depth=depth)
        return wire.Subscription(self.session, key, depth=depth, wake=wake)

    def serve(
        self, key: str, wake: Callable[[], None], *, source: str, puts: bool = True, inflow: Inflow | None = None
    ) -> CommandQueue:
        """Answer commands."""
        return wire.QueryServer(self.session, key, wake, puts=puts, source=source, inflow=inflow)

    def query(
        self,
        key: str,
        payload: bytes,
        *,
        timeout_s: float,
        source: str,
        wake: Callable[[], None],
        origin: Origin | None = None,
    ) -> Question:
        """Ask one key."""
        return wire.PendingQuery(
            self.session, key, payload, timeout_s=timeout_s, source=source, origin=origin, wake=wake
        )

    def newest(self, keys: Iterable[str], *, source: str, timeout_s: float) -> list[RawMessage]:
        """Return the latest values of streams."""
        return wire.ask_all(self.session, keys, source=source, timeout_s=timeout_s)

    def put(self, key: str, message: Any, *, source: str) -> None:
        """Publish once, ahead of all streams."""
        wire.put(self.session, key, message, source=source, urgent=True)

    def document(self, key: str, make: Callable[[], Mapping[str, Any]]) -> object:
        """Answer every query of a key with the same document."""
        return wire.StaticReply(self.session, key, make)

    def presence(self, robot: str, changed: Callable[[str, bool], None]) -> Present:
        """Watch who is there."""
        return wire.Presence(self.session, robot, changed)

    def alive(self, robot: str, name: str) -> object:
        """Show that a capability is there."""
        return wire.alive(self.session, robot, name)

    def close(self) -> None:
        """Leave the bus."""
        self.session.close()
