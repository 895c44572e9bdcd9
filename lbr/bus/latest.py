"""The newest messages of several streams at once, with their ages."""

import contextlib
import time
from collections.abc import Iterable
from typing import Any, NamedTuple

from lbr.bus import codec, stamp, wire
from lbr.bus.session import Session
from lbr.errors import MalformedError


class Latest(NamedTuple):
    """The newest message of a stream; its age is None if its sender has another clock."""

    message: dict[str, Any]
    age_s: float | None


def ask(bus: Session, keys: Iterable[str], *, source: str, timeout_s: float) -> dict[str, Latest]:
    """Return the newest message of each stream by its topic, except streams that do not answer in time."""
    newest: dict[str, Latest] = {}
    for raw in wire.ask_all(bus, keys, source=source, timeout_s=timeout_s):
        sent = stamp.read(raw.attachment)
        age_s = (time.monotonic_ns() - sent.mono_ns) / 1e9 if sent and sent.boot == stamp.boot_id() else None
        with contextlib.suppress(MalformedError):  # a program may publish anything
            value = codec.decode(raw.payload)
            if isinstance(value, dict):
                newest[raw.key.partition("/")[2]] = Latest(value, age_s)
    return newest
