"""What a capability borrows because of a command: asked for in the name and with the date of who sent that."""

from typing import Protocol

from msgspec import Struct

from lbr.bus.stamp import Origin
from lbr.capability.context import Call, PendingReply


class Asking(Protocol):
    """The part of a context that is needed here."""

    def ask(self, request: str, message: Struct, timeout_s: float, *, origin: Origin | None = None) -> PendingReply:
        """Ask every capability wired to a request."""

    def clock(self) -> float:
        """Monotonic seconds."""


class OnBehalf:
    """A transport of leases for what one command wants: what moves then knows whose line that was, and how old."""

    def __init__(self, ctx: Asking, call: Call) -> None:
        self.clock = ctx.clock
        self._ctx = ctx
        self._origin = Origin(call.by or call.source, call.arrived - call.waited_s)

    def ask(self, request: str, message: Struct, timeout_s: float) -> PendingReply:
        """Ask by a request port."""
        return self._ctx.ask(request, message, timeout_s, origin=self._origin)
