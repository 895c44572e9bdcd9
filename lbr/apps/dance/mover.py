"""Moving the base by a lease: taken at rest, renewed at 10 Hz, changed at once, and given up whenever it is lost."""

from math import nan
from typing import Any, Protocol

from lbr.apps.dance.choreography import REST, Move
from lbr.capability.context import Asked
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import DEAD_LEASE, CommandReply, StopCommand

RENEW_S = 0.1
SILENT_S = 0.5
ANSWER_S = 1.0
MOST_WAITING = 8
TAKING_POWER = 0.001
"""No lease is given for standing still; so much moves nothing, and a stop from now on ends what has not begun yet."""


class Asking(Protocol):
    """What is needed of a context."""

    def ask(self, request: str, message: Any, timeout_s: float) -> Asked:
        """Ask by a request port."""

    def clock(self) -> float:
        """Monotonic seconds."""


class Mover:
    """Holds the base for one dance. `ended` says why it does so no more, or nothing."""

    def __init__(self, ctx: Asking, first: Move) -> None:
        self.ended = ""
        self.changes = 0
        self._ctx = ctx
        self._lease = ""
        self._wanted = self._sent = REST
        self._renewed = self._heard = nan
        self._asked: list[Asked] = []
        taking = DriveCommand(power=TAKING_POWER, angle_deg=first.angle_deg)
        self._taking: Asked | None = ctx.ask("motion", taking, ANSWER_S)

    @property
    def holds(self) -> bool:
        """Whether it has the base."""
        return bool(self._lease) and not self.ended

    def move(self, move: Move) -> None:
        """Move so from now on."""
        if self.holds and move != self._wanted:
            self._wanted = move
            self.changes += 1

    def step(self) -> None:
        """Read the answers, and renew or change when it is due."""
        if self.ended:
            return
        if self._taking is not None:
            self._take(self._taking)
        for asked in [asked for asked in self._asked if asked.answers() is not None]:
            self._asked.remove(asked)
            self._read(asked)
        if self.holds:
            self._go_on(self._ctx.clock())

    def release(self) -> None:
        """Stop the base, if it is still ours to stop or may become so."""
        if not self.ended:
            self._halt("the dance is over")
            self.ended = "released"

    def _take(self, taking: Asked) -> None:
        answers = taking.answers()
        if answers is None:
            return
        self._taking = None
        reply = next(iter(answers.values()), None)
        if len(answers) != 1:
            self.ended = f"'motion' must be wired to one drive by a channel row, and is to {len(answers)}"
        elif not isinstance(reply, CommandReply):
            self.ended = f"'{next(iter(answers))}' does not answer"
        elif not (reply.accepted and reply.lease):
            self.ended = reply.reason or "the base was refused"
        else:
            self._lease, self._heard = reply.lease, self._ctx.clock()
            self._send(self._heard)

    def _read(self, asked: Asked) -> None:
        for reply in (asked.answers() or {}).values():
            if isinstance(reply, CommandReply):
                self._heard = self._ctx.clock()
                if not reply.accepted:
                    self._refused(reply.reason or "the move was refused")

    def _refused(self, why: str) -> None:
        """Give up; a refused change leaves the base at the move before, which has no music any more."""
        if not self.ended and not why.startswith(DEAD_LEASE):
            self._halt(why[:100])
        self.ended = self.ended or why.removeprefix(DEAD_LEASE)

    def _halt(self, why: str) -> None:
        self._ctx.ask("halt", StopCommand(reason=why), ANSWER_S)

    def _go_on(self, now: float) -> None:
        if not now - self._heard <= SILENT_S:
            self.ended = "the drive does not answer; the base has stopped by itself"
        elif self._wanted != self._sent or not now - self._renewed < RENEW_S:
            self._send(now)

    def _send(self, now: float) -> None:
        if len(self._asked) >= MOST_WAITING:
            return
        self._sent, self._renewed = self._wanted, now
        command = DriveCommand(power=self._sent.power, angle_deg=self._sent.angle_deg, lease=self._lease)
        self._asked.append(self._ctx.ask("motion", command, ANSWER_S))
