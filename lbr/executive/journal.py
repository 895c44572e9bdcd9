"""What happened: published on `@event`, shown at the console, written down in the database. Never blocks motion."""

import time
from collections import deque
from collections.abc import Callable

from lbr.bus import keys, stamp, wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.database.store import Database
from lbr.errors import LbrError, MalformedError
from lbr.messages.system import Event

WRITE_EVERY_S = 0.25
MOST_WAITING = 2000
LARGEST_EVENT_BYTES = 16 * 1024
_decoder = Decoder(Event)


class Journal:
    """Collects the executive's own events and everybody else's, and writes them down in batches."""

    def __init__(self, bus: Session, robot: str, database: Database, wake: Callable[[], None]) -> None:
        self.listeners: list[Callable[[Event], None]] = []
        self._database = database
        self._waiting: deque[Event] = deque(maxlen=MOST_WAITING)
        self._write_at = 0.0
        self._complain_at = 0.0
        self._publisher = wire.Publisher(bus, keys.event(robot), "executive")
        self._others = wire.Subscription(bus, keys.event(robot), depth=512, wake=wake)

    def happened(self, kind: str, subject: str, text: str, level: str = "info") -> None:
        """Tell everybody; from the executive's own thread."""
        event = Event(kind=kind, subject=subject, text=text, level=level, wall_ns=time.time_ns())  # type: ignore[arg-type]
        self._publisher.put(event)
        self._keep(event)

    def step(self, now: float) -> None:
        """Take in what others said and write it down when it is time."""
        for raw in self._others.take():
            found = stamp.read(raw.attachment)
            if found is not None and found.source == "executive":
                continue
            try:
                self._keep(_decoder.decode(raw.payload[: LARGEST_EVENT_BYTES + 1]))
            except MalformedError as err:
                self._complain(
                    f"an event from '{found.source[:80] if found else 'a bus client'}' is malformed: {err}", now
                )
        if self._waiting and now >= self._write_at:
            self._write_at = now + WRITE_EVERY_S
            self.flush()

    def flush(self) -> None:
        """Write down what waits; a database that cannot take it now gets it later."""
        batch = list(self._waiting)
        try:
            self._database.append_events(batch)
        except LbrError:
            return
        for _ in batch:
            self._waiting.popleft()

    def _complain(self, text: str, now: float) -> None:
        if now >= self._complain_at:
            self._complain_at = now + 1.0
            self.happened("refused", "event", text[:500], "warning")

    def _keep(self, event: Event) -> None:
        self._waiting.append(event)
        for listener in self.listeners:
            listener(event)
