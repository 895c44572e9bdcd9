"""Events: published on `@event`, shown at the console, stored in the database. Never blocks motion."""

import contextlib
import time
from collections import deque
from collections.abc import Callable, Sequence
from math import inf
from typing import Literal

import msgspec

from lbr.bus import keys, stamp, wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.capability.calls import UNSTAMPED
from lbr.database.rows import AuditRow
from lbr.database.store import Database
from lbr.errors import LbrError, MalformedError
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.services import Service
from lbr.messages.codes import Code
from lbr.messages.schema import JsonObject
from lbr.messages.system import Event, Stamp

WRITE_EVERY_S = 0.25
AGAIN_AFTER_S = 1.0
TROUBLE_AFTER_S = 0.5
"""A shorter lock by another writer is not a trouble: the waiting events are written at the next step."""
MOST_WAITING = 2000
LARGEST_EVENT_BYTES = 16 * 1024
OTHERS_PER_S = 20.0
OTHERS_AT_ONCE = 200.0
_RUNS = ("run", "shutdown", "host_joined", "host_lost", "python", "external", "listening", "command")
_PROCESSES = ("started", "stopped", "crashed", "hung", "taken_along", "ended", "failed")
_MOTION = ("fault", "trip", "holder", "reached", "interval", "lapsed", "superseded", "mqtt_asked")
_STOPS = ("estop", "estop_reset")
_PEOPLE = ("login", "login_refused", "logout", "token", "pair", "pair_refused", "paired")
_ROWS = ("rows_changed", "rows_refused", "rows_on_trial", "rows_kept", "rows_back", "edit")
AUDITED = frozenset((*_RUNS, *_PROCESSES, *_MOTION, *_STOPS, *_PEOPLE, *_ROWS))
"""The kinds of events that go into the audit trail, from any source."""

_NO_WHY = ("run", "ready", "python", "external", "pair", "paired", "token", "host_joined", "trouble_over", "busy_over")
_NO_WHY_OF_ROWS = ("rows_changed", "rows_good", "rows_on_trial", "rows_kept", "edit")
CODES: dict[str, Code | Literal[""]] = {
    **dict.fromkeys((*_NO_WHY, *_NO_WHY_OF_ROWS), ""),
    "rows_back": "not_ready",
    "pair_refused": "token",
    "not_ready": "failed",
    "restarting": "changed",
    "shutdown": "shutting_down",
    "estop": "estop",
    "estop_acknowledged": "done",
    "estop_overdue": "timeout",
    "estop_reset": "done",
    "refused": "malformed",
    "rows_refused": "bad_value",
    "learnt_lost": "failed",
    "slow_disk": "timeout",
    "trouble": "failed",
    "too_busy": "busy",
    "host_lost": "unreachable",
    "link_mended": "unreachable",
}
"""The codes of the executive's own events, unless one has a more precise code; empty: this kind has no code."""
WRITTEN_FIRST = frozenset(["rows_changed"])
"""Published only once stored: a receiver may begin the next edit, which must not meet our transaction."""

MOST_ECHOES = 1024
MOST_RECENT = 50
NOT_WRITTEN = "events and the audit trail are not written down"
_decoder = Decoder(Event)


def sender(sent: Stamp | None) -> str:
    """Return the sender that a message's stamp names."""
    return sent.source[:80] if sent is not None and sent.source else UNSTAMPED


class Journal(Service):
    """Collects the executive's own events and everybody else's, and stores them in batches.

    Entries of the audit trail are written to the disk at the next step. `written` receives the written events, and
    `listeners` are called at each event of the executive's own. `recent` are the newest events, oldest first;
    `troubles` are the executive's present problems, besides bad rows.
    """

    def __init__(
        self,
        bus: Session,
        robot: str,
        database: Database,
        wake: Callable[[], None],
        written: Callable[[Sequence[Event]], None],
    ) -> None:
        self.listeners: list[Callable[[], None]] = []
        self.recent: tuple[Event, ...] = ()
        self.troubles: dict[str, str] = {}
        self._robot = robot
        self._database = database
        self._written = written
        self._waiting: deque[Event] = deque(maxlen=MOST_WAITING)
        self._trail: deque[AuditRow] = deque()
        self._lost = 0
        self._failing_since = inf
        self._budget = OTHERS_AT_ONCE
        self._budget_at = 0.0
        self._write_at = 0.0
        self._complain_at = 0.0
        self._echoes: deque[bytes] = deque(maxlen=MOST_ECHOES)
        self._publisher = wire.Publisher(bus, keys.event(robot), "executive")
        self._others = wire.Subscription(bus, keys.event(robot), depth=512, wake=wake)

    def happened(
        self,
        kind: str,
        subject: str,
        text: str,
        level: str = "info",
        code: str | None = None,
        *,
        data: JsonObject | None = None,
        about: str = "",
    ) -> None:
        """Publish an event with its own code or that of its kind; from the executive's own thread."""
        event = Event(
            kind=kind,
            subject=subject,
            text=text,
            level=level,  # type: ignore[arg-type]
            wall_ns=time.time_ns(),
            data=data or {},
            code=CODES.get(kind, "") if code is None else code,
            about=about,
        )
        self._keep(event, EXECUTIVE, allowed=True)
        if kind in WRITTEN_FIRST:
            self.flush()
        self._echoes.append(self._publisher.put(event))
        for listener in self.listeners:
            listener()

    def trouble(self, problem: str, why: str) -> None:
        """Report a `problem` with its reason once, and its end once: `why` is empty then."""
        if why:
            text = f"{problem}: {why}"
            if self.troubles.get(problem) != text:
                self.troubles[problem] = text
                self.happened("trouble", EXECUTIVE, text, "error")
        elif self.troubles.pop(problem, ""):
            self.happened("trouble_over", EXECUTIVE, f"{problem}: no longer so")

    def record(self, kind: str, who: str, text: str) -> None:
        """Add an entry to the audit trail that is not an event; limited to the same rate as others' events."""
        self._audit(Event(kind=kind, subject="console", text=text), who, allowed=self._budget >= 1)

    def step(self, now: float) -> float:
        """Receive the events of others, and store them when it is time."""
        self._budget = min(OTHERS_AT_ONCE, self._budget + (now - self._budget_at) * OTHERS_PER_S)
        self._budget_at = now
        for raw in self._others.take():
            source = sender(stamp.read(raw.attachment))
            if raw.attachment in self._echoes:
                self._echoes.remove(raw.attachment)
                continue
            if source == EXECUTIVE:
                source = "a client that is not the executive"
            try:
                self._keep(_decoder.decode(raw.payload[: LARGEST_EVENT_BYTES + 1]), source, allowed=self._budget >= 1)
            except MalformedError as err:
                self._complain(f"an event from '{source}' is malformed: {err}", now)
        if (self._waiting or self._trail) and now >= self._write_at:
            self._write_at = now + (WRITE_EVERY_S if self.flush() else AGAIN_AFTER_S)
        return inf

    def close(self) -> None:
        """Store the waiting events, and that the run has ended in order."""
        self.step(time.monotonic())
        self.flush()
        with contextlib.suppress(LbrError):
            self._database.record_shutdown(self._robot)

    def flush(self) -> bool:
        """Store the waiting events; return whether that succeeded. Otherwise the database gets them later."""
        events, trail = list(self._waiting), list(self._trail)
        if self._lost:
            trail.append(self._entry("lost", "audit", EXECUTIVE, f"{self._lost} entries, of too many at once"))
        began = time.monotonic()
        try:
            self._database.append_events(events, trail)
        except LbrError as err:
            self._failing_since = min(self._failing_since, began)
            if began - self._failing_since >= TROUBLE_AFTER_S:
                self.trouble(NOT_WRITTEN, str(err))
            return False
        self._waiting.clear()
        self._trail.clear()
        self._written(events)
        self._lost, self._failing_since = 0, inf
        self.trouble(NOT_WRITTEN, "")
        return True

    def _complain(self, text: str, now: float) -> None:
        if now >= self._complain_at:
            self._complain_at = now + 1.0
            self.happened("refused", "event", text[:500], "warning")

    def _keep(self, event: Event, source: str, *, allowed: bool) -> None:
        self._waiting.append(event)
        if event.kind in AUDITED:
            self._audit(event, source, allowed=allowed)
        self.recent = (*self.recent[1 - MOST_RECENT :], event)

    def _audit(self, event: Event, source: str, *, allowed: bool) -> None:
        if source != EXECUTIVE:
            self._budget = max(0.0, self._budget - 1)
        if not allowed or len(self._trail) >= MOST_WAITING:
            self._lost += 1
            return
        figures = f" {msgspec.json.encode(event.data).decode()}" if event.data else ""
        self._trail.append(self._entry(event.kind, event.subject, source, event.text + figures))
        if self._failing_since == inf:
            self._write_at = 0.0

    def _entry(self, kind: str, subject: str, source: str, text: str) -> AuditRow:
        return AuditRow(wall_ns=time.time_ns(), kind=kind, subject=subject, source=f"{self._robot}/{source}", text=text)
