"""A look at the bus from outside: its streams, their real rates, and their delays."""

import time
from collections import deque
from dataclasses import dataclass

import zenoh

from lbr.bus import stamp as stamps
from lbr.bus import wire
from lbr.errors import BusError


def survey(session: zenoh.Session, key: str, *, source: str, timeout_s: float = 2.0) -> list[wire.RawMessage]:
    """Ask everybody behind a key expression, and return every answer."""
    try:
        replies = session.get(
            key,
            attachment=stamps.make(source, 0),
            timeout=timeout_s,
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
        )
        return [wire.raw(reply.ok) for reply in replies if reply.ok is not None]
    except zenoh.ZError as err:
        raise BusError(f"{key}: {wire.plain(err)}") from err


@dataclass(frozen=True, slots=True)
class Arrival:
    """A message's stamp and its arrival, by this machine's monotonic clock."""

    key: str
    attachment: bytes
    size: int
    arrived_ns: int


class Arrivals:
    """Records the arrival of every message on a key, without decoding on the bus library's thread."""

    def __init__(self, session: zenoh.Session, key: str, *, depth: int = 200_000) -> None:
        self.count = 0
        self._slots: deque[Arrival] = deque(maxlen=depth)
        self._subscriber = session.declare_subscriber(key, wire.direct(self._store))

    def take(self) -> list[Arrival]:
        """Return the arrivals since the last call, oldest first."""
        return wire.drained(self._slots)

    def close(self) -> None:
        """Stop listening."""
        self._subscriber.undeclare()

    def _store(self, sample: zenoh.Sample) -> None:
        arrived_ns = time.monotonic_ns()
        attachment = sample.attachment
        stamp = attachment.to_bytes() if attachment is not None else b""
        self.count += 1
        self._slots.append(Arrival(str(sample.key_expr), stamp, len(sample.payload), arrived_ns))
