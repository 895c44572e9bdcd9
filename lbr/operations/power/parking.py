"""Parking the robot before the power fails: a motion under a renewed lease, then the release of its joints."""

from lbr.capability.context import Context
from lbr.leases.client import ANSWER_S, LeaseTarget, PendingReply
from lbr.leases.holder import Holder
from lbr.messages.codes import Reason
from lbr.messages.joints import PlayCommand, TorqueCommand
from lbr.messages.leases import CommandReply
from lbr.operations.power import PowerSettings

RESULT_S = 0.3
"""The delay after the end of a lease by which the result of a motion may arrive."""
MOTIONS = LeaseTarget(
    "park", "halt", "player of motions", "the motions do not answer; the joints hold by themselves", result_s=RESULT_S
)
AGAIN_S = 0.2


class Parking:
    """One parking. `done` once nothing is left to do; `trouble` has the failures in words."""

    def __init__(self, ctx: Context[PowerSettings]) -> None:
        self.done = False
        self.trouble = ""
        self._ctx = ctx
        self._settings = settings = ctx.settings
        self._until = ctx.clock() + settings.park_s
        self._holder = Holder(ctx, renewal=PlayCommand(motion=settings.park_motion or "none"))
        self._asked: PendingReply | None = None
        self._ask_at = 0.0
        ctx.take("parked")
        if settings.park_motion and ctx.targets(MOTIONS.motion):
            self._holder.begin(MOTIONS, PlayCommand(motion=settings.park_motion, take_over=True))
        else:
            self._release_joints()

    def step(self) -> None:
        """Continue; called often."""
        if self._holder.lease is not None:
            self._follow(self._ctx.clock())
        elif not self.done:
            self._release(self._ctx.clock())

    def stop(self) -> None:
        """End it now; joints hold, or stay released."""
        self._holder.release("the shutdown is off")
        self.done = True

    def _follow(self, now: float) -> None:
        late = f"'{self._settings.park_motion}' was not over within {self._settings.park_s:g} s"
        results = [received.message for received in self._ctx.take("parked")]
        ended = self._holder.step(results, Reason("timeout", late) if now >= self._until else None)
        if ended is not None:
            self._release_joints("" if self._holder.good else ended.text)

    def _release_joints(self, trouble: str = "") -> None:
        self._note(trouble)
        self._holder.release("it is over")
        self._until = self._ctx.clock() + self._settings.let_go_s
        self.done = not self._ctx.targets("let_go")

    def _release(self, now: float) -> None:
        """Release the joints; refusals while another holds them are retried until the time limit."""
        answers = self._asked.answers() if self._asked is not None else None
        if answers is not None:
            self._asked = None
            replies = [reply if isinstance(reply, CommandReply) else None for reply in answers.values()]
            self.done = all(reply is not None and reply.accepted for reply in replies)
        if not self.done and now >= self._until:
            self._note("the joints were not released in time")
            self.done = True
        elif not self.done and self._asked is None and now >= self._ask_at:
            self._ask_at = now + AGAIN_S
            self._asked = self._ctx.ask("let_go", TorqueCommand(on=False, confirmed=True), ANSWER_S)

    def _note(self, trouble: str) -> None:
        self.trouble = "; ".join(filter(None, (self.trouble, trouble)))
