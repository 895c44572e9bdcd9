"""Bringing the robot down before the power goes: a motion under a lease that is kept up, then its joints let go."""

from typing import Protocol

from lbr.capability.context import Asked, Received
from lbr.capability.loan import ANSWER_S, Asking, Lender, Loan
from lbr.messages.drive import GoalResult
from lbr.messages.joints import PlayCommand, TorqueCommand
from lbr.messages.leases import CommandReply
from lbr.operations.power import PowerSettings

MOTIONS = Lender("park", "halt", "player of motions", "the motions do not answer; the joints hold by themselves")
AGAIN_S = 0.2
RESULT_S = 0.3
"""How much later than a dead lease the result of a motion may be heard."""


class Wired(Asking, Protocol):
    """What is needed of a context."""

    def targets(self, request: str) -> tuple[str, ...]:
        """Return who is wired to it."""

    def take(self, port: str) -> list[Received]:
        """Return what came on an input."""


class Parking:
    """One parking. `done` once nothing is left to do; `trouble` is what did not go well, in words."""

    def __init__(self, ctx: Wired, settings: PowerSettings) -> None:
        self.done = False
        self.trouble = ""
        self._ctx = ctx
        self._settings = settings
        self._until = ctx.clock() + settings.park_s
        self._play = PlayCommand(motion=settings.park_motion or "none")
        self._loan: Loan | None = None
        self._ended_at: float | None = None
        self._asked: Asked | None = None
        self._ask_at = 0.0
        ctx.take("parked")
        if settings.park_motion and ctx.targets(MOTIONS.motion):
            self._loan = Loan(ctx, MOTIONS, PlayCommand(motion=settings.park_motion, take_over=True))
        else:
            self._let_go()

    def step(self) -> None:
        """Go on; called often."""
        if self._loan is not None:
            self._follow(self._loan, self._ctx.clock())
        elif not self.done:
            self._release(self._ctx.clock())

    def stop(self) -> None:
        """End it where it is; joints hold, or stay let go."""
        if self._loan is not None:
            self._loan.release("the shutdown is off")
        self._loan, self.done = None, True

    def _follow(self, loan: Loan, now: float) -> None:
        loan.step()
        result = self._result(loan)
        if result is not None:
            self._let_go("" if result.result == "reached" else result.reason or result.result)
        elif loan.ended:
            self._ended_at = now if self._ended_at is None else self._ended_at
            if loan.granted is None or now - self._ended_at >= RESULT_S:
                self._let_go(loan.ended.text)
        elif now >= self._until:
            loan.release("it took too long")
            self._let_go(f"'{self._settings.park_motion}' was not over within {self._settings.park_s:g} s")
        elif loan.due:
            loan.send(self._play)

    def _result(self, loan: Loan) -> GoalResult | None:
        """Return how the motion ended."""
        for received in self._ctx.take("parked"):
            result = received.message
            if isinstance(result, GoalResult) and loan.granted is not None and result.goal == loan.granted.goal:
                return result
        return None

    def _let_go(self, trouble: str = "") -> None:
        self._note(trouble)
        self._loan = None
        self._until = self._ctx.clock() + self._settings.let_go_s
        self.done = not self._ctx.targets("let_go")

    def _release(self, now: float) -> None:
        """Let go; whoever holds the joints a moment longer has it refused, so it is tried again until time is up."""
        answers = self._asked.answers() if self._asked is not None else None
        if answers is not None:
            self._asked = None
            replies = [reply if isinstance(reply, CommandReply) else None for reply in answers.values()]
            self.done = all(reply is not None and reply.accepted for reply in replies)
        if not self.done and now >= self._until:
            self._note("the joints were not let go in time")
            self.done = True
        elif not self.done and self._asked is None and now >= self._ask_at:
            self._ask_at = now + AGAIN_S
            self._asked = self._ctx.ask("let_go", TorqueCommand(on=False, confirmed=True), ANSWER_S)

    def _note(self, trouble: str) -> None:
        self.trouble = "; ".join(filter(None, (self.trouble, trouble)))
