"""The layer below a capability's context: clock, streams, commands and presence; on Zenoh or in `lbr.bus.memory`."""

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias
from weakref import WeakSet

import zenoh

from lbr.bus import session, wire
from lbr.bus.inflow import Inflow
from lbr.bus.stamp import Origin
from lbr.bus.wire import CommandQueue, RawMessage

if TYPE_CHECKING:
    from lbr.bus.memory import MemoryFeed, MemoryTransport

Feed: TypeAlias = "wire.Subscription | wire.PolledSubscription | MemoryFeed"
Transport: TypeAlias = "ZenohTransport | MemoryTransport"
BORROWED_TRIES, BORROWED_S = 50, 0.001
"""A thread that uses a declaration has done so within microseconds."""


class Question(Protocol):
    """A query under way."""

    done: bool
    replies: list[RawMessage]


class ZenohTransport:
    """One participant's part of the bus, on a session of Zenoh. `leave` closes the session, or leaves it to others.

    On a `shared` session, closing withdraws only the declarations made here.
    """

    def __init__(self, opened: session.Session, leave: Callable[[], None], *, shared: bool = False) -> None:
        self.session = opened
        self.clock = time.monotonic
        self._leave = leave
        self._shared = shared
        self._declared: list[Callable[[], object]] = []
        self._feeds: WeakSet[wire.Subscription | wire.PolledSubscription] = WeakSet()

    def publisher(
        self,
        key: str,
        source: str,
        *,
        seal: bytes = b"",
        pictures: bool = False,
        watching: Callable[[], None] | None = None,
    ) -> wire.Publisher:
        """Publish a stream; `watching` is called when `watched` has changed."""
        publisher = wire.Publisher(self.session, key, source, seal=seal, pictures=pictures, watching=watching)
        self._declared.append(publisher.close)
        return publisher

    def subscribe(
        self, key: str, *, depth: int, wake: Callable[[], None] | None
    ) -> wire.Subscription | wire.PolledSubscription:
        """Receive the newest `depth` messages of a stream; without `wake`, Zenoh keeps them until they are taken."""
        feed = (
            wire.PolledSubscription(self.session, key, depth=depth)
            if wake is None
            else wire.Subscription(self.session, key, depth=depth, wake=wake)
        )
        self._feeds.add(feed)
        return feed

    def serve(
        self, key: str, wake: Callable[[], None], *, source: str, puts: bool = True, inflow: Inflow | None = None
    ) -> CommandQueue:
        """Answer commands."""
        server = wire.QueryServer(self.session, key, wake, puts=puts, source=source, inflow=inflow)
        self._declared.append(server.close)
        return server

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
        """Return the latest values of the streams that answer in time."""
        return wire.ask_all(self.session, keys, source=source, timeout_s=timeout_s)

    def put(self, key: str, message: Any, *, source: str) -> None:
        """Publish once, ahead of all streams; raise BusError if it was not sent."""
        wire.put(self.session, key, message, source=source, urgent=True)

    def document(self, key: str, make: Callable[[], Mapping[str, Any]]) -> None:
        """Answer every query of a key with the same document."""
        self._declared.append(wire.StaticReply(self.session, key, make).close)

    def presence(self, robot: str, changed: Callable[[str, bool], None]) -> wire.Presence:
        """Watch who is present."""
        presence = wire.Presence(self.session, robot, changed)
        self._declared.append(presence.close)
        return presence

    def alive(self, robot: str, name: str) -> None:
        """Show that a capability is present."""
        self._declared.append(wire.alive(self.session, robot, name).undeclare)

    def close(self) -> None:
        """Leave the bus."""
        if self._shared:
            for take_back in (*self._declared, *(feed.close for feed in self._feeds)):
                _once_unborrowed(take_back)
            self._declared.clear()
        self._leave()


class SharedSession:
    """One session for several participants of a process, from the first to the last of them.

    Their messages to each other stay within the process; messages of others arrive once for all of them.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._session: session.Session | None = None
        self._parts = 0

    def enter(self, connect: Callable[[], session.Session]) -> ZenohTransport:
        """Return a participant's part; raise BusError if the router refuses it."""
        with self._lock:
            self._session = self._session or connect()
            self._parts += 1
            return ZenohTransport(self._session, self._leave, shared=True)

    def _leave(self) -> None:
        with self._lock:
            self._parts -= 1
            left, self._session = (None, self._session) if self._parts else (self._session, None)
        if left is not None:
            left.close()


def _once_unborrowed(take_back: Callable[[], object]) -> None:
    """Withdraw a declaration once no other thread uses it; it may have been withdrawn already."""
    for _ in range(BORROWED_TRIES):
        with suppress(zenoh.ZError):
            try:
                take_back()
            except RuntimeError:  # "Already borrowed"
                time.sleep(BORROWED_S)
                continue
        return
