"""Motion borrowed from another capability: asked for by a request port, renewed at 10 Hz, given up whenever it is lost."""

from dataclasses import dataclass
from math import nan
from typing import Any, Protocol

from msgspec import Struct
from msgspec.structs import replace

from lbr.capability.context import Asked
from lbr.messages.codes import Reason
from lbr.messages.leases import CommandReply, StopCommand

RENEW_S = 0.1
SILENT_S = 0.5
"""A lender that answers nothing for so long is silent. A round of ours counts as `RENEW_S` at most: while we were held
up ourselves we neither asked nor read, and the lease alone tells whether that was too long."""
ANSWER_S = 1.0
MOST_WAITING = 8
LONGEST_REASON = 200


class Asking(Protocol):
    """What is needed of a context."""

    def ask(self, request: str, message: Any, timeout_s: float) -> Asked:
        """Ask by a request port."""

    def clock(self) -> float:
        """Monotonic seconds."""


@dataclass(frozen=True, slots=True)
class Lender:
    """Whom to borrow from: the request ports to move and to halt it, what it is, and what it does once it is silent."""

    motion: str
    halt: str
    kind: str
    silent: str


class Loan:
    """A lease. `ended` says why it is no more, if it is; `granted` is the answer to what it was asked for."""

    def __init__(self, ctx: Asking, lender: Lender, first: Struct) -> None:
        self.ended: Reason | None = None
        self.granted: CommandReply | None = None
        self._ctx = ctx
        self._lender = lender
        self._sent = self._looked = nan
        self._unheard_s = 0.0
        self._asked: list[Asked] = []
        self._taking: Asked | None = ctx.ask(lender.motion, first, ANSWER_S)

    @property
    def holds(self) -> bool:
        """Whether motion can be sent by it."""
        return self.granted is not None and not self.ended

    @property
    def due(self) -> bool:
        """Whether it is time to renew it."""
        return self.holds and not self._ctx.clock() - self._sent < RENEW_S

    def step(self) -> None:
        """Read the answers."""
        if self.ended:
            return
        if self._taking is not None:
            self._take(self._taking)
        now = self._ctx.clock()
        self._unheard_s += min(RENEW_S, now - self._looked)  # this way round, NaN counts as RENEW_S
        self._looked = now
        for asked in [asked for asked in self._asked if asked.answers() is not None]:
            self._asked.remove(asked)
            self._read(asked)
        if self.holds and not self._unheard_s <= SILENT_S:
            self.ended = Reason("unreachable", self._lender.silent)

    def send(self, message: Struct) -> Asked | None:
        """Renew or change the motion; None if too much waits for answers, and nothing was sent."""
        if not self.holds or self.granted is None or len(self._asked) >= MOST_WAITING:
            return None
        self._sent = self._ctx.clock()
        command = replace(message, lease=self.granted.lease)
        asked = self._ctx.ask(self._lender.motion, command, ANSWER_S)
        self._asked.append(asked)
        return asked

    def release(self, why: str, *, lost: bool = False) -> None:
        """Halt what was borrowed, if it is still ours to halt or may become so; `lost`: whoever wanted it is gone."""
        if not self.ended:
            self._halt(why, lost=lost)
            self.ended = Reason("cancelled", "released")

    def _take(self, taking: Asked) -> None:
        answers = taking.answers()
        if answers is None:
            return
        self._taking = None
        reply = next(iter(answers.values()), None)
        if len(answers) != 1:
            lender = self._lender
            self.ended = Reason(
                "wiring",
                f"'{lender.motion}' must be wired to one {lender.kind} by a channel row, and is to {len(answers)}",
            )
        elif not isinstance(reply, CommandReply):
            self.ended = Reason("unreachable", f"'{next(iter(answers))}' does not answer")
        elif not (reply.accepted and reply.lease):
            self.ended = reply.why
        else:
            self.granted, self._unheard_s = reply, 0.0

    def _read(self, asked: Asked) -> None:
        for reply in (asked.answers() or {}).values():
            if isinstance(reply, CommandReply):
                self._unheard_s = 0.0
                if not reply.accepted:
                    self._refused(reply)

    def _refused(self, reply: CommandReply) -> None:
        """Give up; a refused change leaves the motion at what was before, which nobody wants any more."""
        if not self.ended and reply.code != "dead_lease":
            self._halt(reply.why.text)
        self.ended = self.ended or reply.why

    def _halt(self, why: str, *, lost: bool = False) -> None:
        self._ctx.ask(self._lender.halt, StopCommand(reason=why[:LONGEST_REASON], lost=lost), ANSWER_S)
