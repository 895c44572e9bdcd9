"""The lines of buttons: one at each press. The motion that a line begins lasts while the dead-man button is held."""

from typing import NamedTuple

from msgspec import Struct

from lbr.apps.motion_requests import adopt, target_of
from lbr.capability.context import Context
from lbr.leases.client import PendingReply
from lbr.leases.holder import Holder
from lbr.messages.codes import Reason, heard
from lbr.messages.drive import GoalResult
from lbr.messages.system import ConsoleResult, Hold, LineCommand

SAY_S = 3.0
MOST_WAITING = 4


class _SentLine(NamedTuple):
    line: str
    question: PendingReply


class Lines:
    """Sends lines to the console, and renews the motion of the last one."""

    def __init__(self, ctx: Context[Struct]) -> None:
        self._ctx = ctx
        self._sent: list[_SentLine] = []
        self._holder = Holder(ctx)
        self._line = self._key = ""

    @property
    def moving(self) -> str:
        """Return the line whose motion goes on, or an empty string."""
        return self._line if self._holder.asks else ""

    def send(self, line: str, stands: Reason | None) -> None:
        """Send a line, unless the robot must stand, or too many lines wait for answers."""
        if stands is not None or len(self._sent) >= MOST_WAITING:
            self._report(line, stands or Reason("busy", "too many lines wait for their answer"))
            return
        self._sent.append(_SentLine(line, self._ctx.ask("say", LineCommand(line=line), SAY_S)))

    def step(self, results: list[GoalResult], stands: Reason | None) -> None:
        """Read answers, and renew the motion, unless the robot must stand."""
        for sent in [sent for sent in self._sent if sent.question.answers() is not None]:
            self._sent.remove(sent)
            self._read_answer(sent, next(iter((sent.question.answers() or {}).values()), None))
        ended = self._holder.step(results, stands)
        if ended is not None and not self._holder.good:
            self._report(self._line, ended)

    def halt(self, why: str) -> None:
        """Stop the motion of a line."""
        self._holder.release(why)

    def _read_answer(self, sent: _SentLine, answer: object) -> None:
        if not isinstance(answer, ConsoleResult):
            self._report(sent.line, Reason("unreachable", "it was not answered: is `say` wired to executive.line?"))
        elif answer.code != 0:
            self._report(sent.line, heard(answer.reason_code, answer.text))
        elif answer.hold is not None:
            self._hold(sent.line, answer.hold)

    def _hold(self, line: str, hold: Hold) -> None:
        target = target_of(self._ctx, hold)
        if target is None:
            moved = "/".join(hold.key.split("/")[-2:])
            self._report(line, Reason("not_possible", f"what {moved} moves cannot be held by a gamepad"))
            return
        if not self._key.startswith(hold.key.rpartition("/")[0]):
            self.halt("another line moves something else")
        self._line, self._key = line, hold.key
        adopt(self._holder, target, hold)

    def _report(self, line: str, why: Reason) -> None:
        self._ctx.event("teleop_line", f"'{line}': {why}", level="warning", code=why.code)
