"""Tells who comes and goes at a router."""

from collections import deque
from collections.abc import Callable

import zenoh
from msgspec import Struct

from lbr.bus import wire

MOST_WAITING = 256


class Coming(Struct, frozen=True):
    """A client connected, or left: its address, and its session's id."""

    connected: bool
    address: str
    session_id: str


class Links:
    """Notes every link of a router that uses one of `protocols`; the bus does not report names of users."""

    def __init__(
        self, session: zenoh.Session, protocols: tuple[str, ...], wake: Callable[[], None] = lambda: None
    ) -> None:
        self.missed = 0
        self._prefixes = tuple(f"{protocol}/" for protocol in protocols)
        self._slots: deque[Coming] = deque()
        self._wake = wake
        self._listener: zenoh.LinkEventsListener[None] | None = session.info.declare_link_events_listener(
            wire.direct(self._note), history=True
        )

    def take(self) -> list[Coming]:
        """Return what happened since the last call, oldest first."""
        return wire.drained(self._slots)

    def close(self) -> None:
        """Note nothing any more."""
        if self._listener is not None:
            self._listener.undeclare()
            self._listener = None

    def _note(self, event: zenoh.LinkEvent) -> None:
        link = event.link
        if not link.src.startswith(self._prefixes):
            return
        if len(self._slots) >= MOST_WAITING:
            self.missed += 1
            return
        address = link.dst.partition("/")[2]
        self._slots.append(Coming(event.kind == zenoh.SampleKind.PUT, address, str(link.zid)))
        self._wake()
