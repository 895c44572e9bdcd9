"""Bringing the robot down before the power goes: a motion under a lease that is kept up, then its joints let go."""

from typing import Any, Literal, Protocol

from lbr.capability.context import Asked, Received
from lbr.messages.joints import PlayCommand, TorqueCommand
from lbr.messages.leases import CommandReply
from lbr.operations.power import PowerSettings

RENEW_S = 0.1
ANSWER_S = 1.0
AGAIN_S = 0.2
MOST_WAITING = 8


class Asking(Protocol):
    """What is needed of a context."""

    def ask(self, request: str, message: Any, timeout_s: float) -> Asked:
        """Ask by a request port."""

    def targets(self, request: str) -> tuple[str, ...]:
        """Return who is wired to it."""

    def take(self, port: str) -> list[Received]:
        """Return what came on an input."""

    def clock(self) -> float:
        """Monotonic seconds."""


class Parking:
    """One parking. `done` once nothing is left to do; `trouble` is what did not go well, in words."""

    def __init__(self, ctx: Asking, settings: PowerSettings) -> None:
        self.done = False
        self.trouble = ""
        self._ctx = ctx
        self._settings = settings
        self._stage: Literal["motion", "torque"] = "motion"
        self._until = ctx.clock() + settings.park_s
        self._lease = self._goal = ""
        self._asked: list[Asked] = []
        self._next = 0.0
        ctx.take("parked")
        if not (settings.park_motion and ctx.targets("park")):
            self._let_go()

    def step(self) -> None:
        """Go on; called often."""
        now = self._ctx.clock()
        if not self.done:
            if self._stage == "motion":
                self._play(now)
            else:
                self._release(now)

    def _play(self, now: float) -> None:
        ended = [one.message for one in self._ctx.take("parked") if self._goal and one.message.goal == self._goal]
        if ended:
            self._let_go("" if ended[-1].result == "reached" else ended[-1].reason or ended[-1].result)
            return
        for reply in self._replies():
            if reply is None:
                continue  # it is asked again anyway
            if not reply.accepted:
                # once it was accepted, a dead lease is how a motion's end is heard of
                self._let_go("" if self._lease else reply.reason)
                return
            self._lease, self._goal = reply.lease or self._lease, reply.goal or self._goal
        if now >= self._until:
            self._let_go(f"'{self._settings.park_motion}' was not over within {self._settings.park_s:g} s")
        elif now >= self._next and len(self._asked) < (MOST_WAITING if self._lease else 1):
            self._next = now + RENEW_S
            play = PlayCommand(motion=self._settings.park_motion, lease=self._lease, take_over=not self._lease)
            self._asked.append(self._ctx.ask("park", play, ANSWER_S))

    def _release(self, now: float) -> None:
        """Let go; a holder whose lease has not lapsed yet refuses, so it is tried again until time is up."""
        replies = self._replies()
        refused = next((reply.reason for reply in replies if reply is not None and not reply.accepted), "")
        if any(reply is not None and reply.accepted for reply in replies):
            self.done = True
        elif now >= self._until:
            self._note(refused or "the joints were not let go in time")
            self.done = True
        elif not self._asked and now >= self._next:
            self._next = now + AGAIN_S
            self._asked.append(self._ctx.ask("let_go", TorqueCommand(on=False, confirmed=True), ANSWER_S))

    def _let_go(self, trouble: str = "") -> None:
        self._note(trouble)
        self._stage, self._asked = "torque", []
        self._until, self._next = self._ctx.clock() + self._settings.let_go_s, 0.0
        self.done = not self._ctx.targets("let_go")

    def _note(self, trouble: str) -> None:
        self.trouble = "; ".join(filter(None, (self.trouble, trouble)))

    def _replies(self) -> list[CommandReply | None]:
        """Return the answers that came, None for each that gave none."""
        found: list[CommandReply | None] = []
        for asked in tuple(self._asked):
            answers = asked.answers()
            if answers is not None:
                self._asked.remove(asked)
                found += [reply if isinstance(reply, CommandReply) else None for reply in answers.values()]
        return found
