"""Requests for motion over a session on the bus, for programs that are not capabilities."""

import time
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any

from lbr.bus import wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.bus.stamp import Origin
from lbr.errors import MalformedError
from lbr.leases.client import PendingReply
from lbr.messages.leases import CommandReply

ANSWER = Decoder(CommandReply)


@dataclass(frozen=True, slots=True)
class OverSession:
    """Asks over a session on the bus; `keys` maps requests to keys.

    `origin` is the user of the motion, with a time: a motion that somebody else has stopped since then does not begin
    again.
    """

    session: Session
    source: str
    keys: Mapping[str, str]
    _: KW_ONLY
    wake: Callable[[], None] = lambda: None
    clock: Callable[[], float] = time.monotonic
    origin: Origin | None = None

    def ask(self, request: str, message: object, timeout_s: float) -> PendingReply:
        """Ask; the answer is a `CommandReply`."""
        key, payload = self.keys[request], wire.encode(message)
        query = wire.PendingQuery(
            self.session, key, payload, timeout_s=timeout_s, source=self.source, origin=self.origin, wake=self.wake
        )
        return _Question(query)


@dataclass(frozen=True, slots=True)
class _Question:
    question: wire.PendingQuery

    def answers(self) -> Mapping[str, Any] | None:
        name = self.question.key.split("/")[-2]
        for raw in self.question.replies:
            try:
                return {name: ANSWER.decode(raw.payload)}
            except MalformedError:
                continue
        return {name: None} if self.question.done else None
