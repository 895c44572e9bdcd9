"""Decides which files stay longer: those around an emergency stop, a crash, a fault, a fall or a mark. Pure."""

import time
from collections import deque

from msgspec import Struct

from lbr.apps.recorder.recording.shelf import Incident
from lbr.messages.system import Event

KINDS = frozenset(
    [
        "estop",
        "crashed",
        "hung",
        "failed",
        "fault",
        "trip",
        "fallen",
        "mover_lost",
        "tilted",
        "overload",
        "servo_latched",
    ]
)
MARK = "mark"
MOST_OF_ONE, WITHIN_S = 6, 3600.0
"""The most incidents of one sort within an hour: an event that repeats must not push out a single one."""


class Keep(Struct):
    """A kept incident by name; files up to `until` belong to it."""

    name: str
    why: Incident
    until: float
    before_s: float = 60.0


class Keeping:
    """The incidents of late. Files of `before_s` and `after_s` around each are kept; the same incident within that time
    joins."""

    def __init__(self, before_s: float, after_s: float) -> None:
        self._before_s = before_s
        self._after_s = after_s
        self._now: dict[tuple[str, str], Keep] = {}
        self._times: dict[tuple[str, str], deque[float]] = {}

    def event(self, event: Event, now: float, wall_ns: int) -> Keep | None:
        """Return what to keep because of an event, or None."""
        if event.kind not in KINDS or event.data.get("latched_before"):
            return None
        return self.incident(event.kind, event.subject, event.text, now, wall_ns)

    def incident(self, kind: str, subject: str, text: str, now: float, wall_ns: int) -> Keep | None:
        """Return what to keep because of an incident; None if there were too many of its kind."""
        key = kind, subject
        current = self._now.get(key)
        if current is not None and now < current.until + self._before_s:
            current.why.again += 1
            current.until = max(current.until, now + self._after_s)
            return current
        times = self._times.setdefault(key, deque(maxlen=MOST_OF_ONE))
        if kind != MARK and len(times) == MOST_OF_ONE and now - times[0] < WITHIN_S:
            return None
        times.append(now)
        if len(self._times) > 256:
            self._times.clear()
        self._now = {one: kept for one, kept in self._now.items() if now < kept.until + self._before_s}
        why = Incident(kind=kind, subject=subject, text=text[:500], wall_ns=wall_ns)
        keep = self._now[key] = Keep(
            name=_name(kind, subject, wall_ns), why=why, until=now + self._after_s, before_s=self._before_s
        )
        return keep


def _name(kind: str, subject: str, wall_ns: int) -> str:
    at = time.strftime("%Y%m%d-%H%M%S", time.localtime(wall_ns / 1e9))
    what = "-".join(part for part in (kind, subject) if part and part != "executive")
    return f"{at}-{''.join(one if one.isalnum() or one in '-_' else '_' for one in what)[:60]}"
