"""The services: the stops, and one for each console line, with the motion that a line begins."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from msgspec import Struct

from lbr.apps.motion_requests import adopt, target_of
from lbr.apps.ros2.kind import ESTOP, STOP
from lbr.capability.context import Context
from lbr.leases.client import PendingReply
from lbr.leases.holder import Holder
from lbr.messages.codes import Reason, heard
from lbr.messages.drive import GoalResult
from lbr.messages.leases import StopCommand
from lbr.messages.system import ConsoleResult, Hold, LineCommand

SAY_S, STOP_S = 3.0, 1.0
MOST_WAITING = 4
FROM_ROS = "stopped from ROS"
Reply = Callable[[str, bool], None]
"""Answers a call: with a text, and whether it succeeded."""


class Waiting(NamedTuple):
    """A call, and the request that must be answered first."""

    service: str
    question: PendingReply
    reply: Reply


class Words:
    """Carries out the calls of services, one motion at a time."""

    def __init__(self, ctx: Context[Struct], lines: Mapping[str, str], denied: Reason | None) -> None:
        self._ctx = ctx
        self._lines = lines
        self._denied = denied
        self._waiting: list[Waiting] = []
        self._holder = Holder(ctx)
        self._service = ""

    @property
    def moving(self) -> str:
        """Return the service whose motion goes on, or an empty string."""
        return self._service if self._holder.asks else ""

    def call(self, service: str, reply: Reply) -> None:
        """Carry out a call; the reply comes at once or later. A stop is for everybody."""
        if service == ESTOP:
            self._ctx.engage_estop("from ROS")
            reply("the emergency stop is engaged", True)
        elif service == STOP:
            self.halt(FROM_ROS)
            question = self._ctx.ask("stop_all", StopCommand(reason=FROM_ROS, whole=True), STOP_S)
            self._waiting.append(Waiting(service, question, reply))
        elif self._denied is not None:
            reply(f"{self._denied} [{self._denied.code}]", False)
        elif len(self._waiting) >= MOST_WAITING:
            reply("too much waits for an answer; ask again [busy]", False)
        else:
            question = self._ctx.ask("say", LineCommand(line=self._lines[service]), SAY_S)
            self._waiting.append(Waiting(service, question, reply))

    def step(self, results: list[GoalResult]) -> None:
        """Read answers, and renew the motion."""
        for call in [call for call in self._waiting if call.question.answers() is not None]:
            self._waiting.remove(call)
            answers = call.question.answers() or {}
            if call.service == STOP:
                silent = sorted(name for name, answer in answers.items() if answer is None)
                call.reply(f"{', '.join(silent)} did not answer" if silent else "stopped", not silent)
            else:
                self._answer(call, next(iter(answers.values()), None))
        ended = self._holder.step(results)
        if ended is not None and not self._holder.good:
            self._report(self._service, ended)

    def halt(self, why: str, *, lost: bool = False) -> None:
        """Stop the motion of a service."""
        self._holder.release(why, lost=lost)

    def _answer(self, call: Waiting, answer: object) -> None:
        if not isinstance(answer, ConsoleResult):
            call.reply("it was not answered [unreachable]", False)
        elif answer.code != 0:
            code = f" [{answer.reason_code}]" if answer.reason_code else ""
            call.reply(f"{answer.text}{code}", False)
        else:
            why = self._hold(call.service, answer.hold) if answer.hold is not None else None
            call.reply(f"{why} [{why.code}]" if why is not None else answer.text, why is None)

    def _hold(self, service: str, hold: Hold) -> Reason | None:
        """Hold the motion that a line began; return why that is not possible, or None."""
        if not hold.goal:
            return Reason("not_possible", "it has no end of its own, and nobody to end it: publish on cmd_vel instead")
        target = target_of(self._ctx, hold)
        if target is None:
            moved = "/".join(hold.key.split("/")[-2:])
            return Reason("not_possible", f"what {moved} moves cannot be held from ROS")
        self._service = service
        adopt(self._holder, target, hold)
        return None

    def _report(self, service: str, why: Reason) -> None:
        text, code = f"{service}: {why}", heard(why.code, why.text).code
        self._ctx.event("ros2_service", text, level="warning", code=code, about=self._ctx.name)
