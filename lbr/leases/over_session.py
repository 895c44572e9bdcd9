"""Asking for motion by a session on the bus, for programs that are no capability."""

import time
from collections.abc import Callable, Mapping
from typing import Any

from lbr.bus import wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.bus.stamp import Origin
from lbr.errors import MalformedError
from lbr.leases.client import PendingReply
from lbr.messages.leases import CommandReply


class OverSession:
    """Asks by a session on the bus: `keys` says which key each request goes to.

    `origin`: who wants the motion, and since when; what was stopped by another since is not begun again.
    """

    def __init__(
        self,
        session: Session,
        source: str,
        keys: Mapping[str, str],
        *,
        wake: Callable[[], None] = lambda: None,
        clock: Callable[[], float] = time.monotonic,
        origin: Origin | None = None,
    ) -> None:
        self.clock = clock
        self._session = session
        self._source = source
        self._keys = keys
        self._wake = wake
        self._origin = origin

    def ask(self, request: str, message: Any, timeout_s: float) -> PendingReply:
        """Ask; the answer is a `CommandReply`."""
        payload = wire.encode(message)
        key = self._keys[request]
        return _Question(
            wire.PendingQuery(
                self._session,
                key,
                payload,
                timeout_s=timeout_s,
                source=self._source,
                origin=self._origin,
                wake=self._wake,
            )
        )


class _Question:
    _decoder = Decoder(CommandReply)

    def __init__(self, question: wire.PendingQuery) -> None:
        self._question = question
        self._name = question.key.split("/")[-2]

    def answers(self) -> Mapping[str, Any] | None:
        for raw in self._question.replies:
            try:
                return {self._name: self._decoder.decode(raw.payload)}
            except MalformedError:
                continue
        return {self._name: None} if self._question.done else None
