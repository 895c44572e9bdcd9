"""Joints operation as a client sees it: leased for one motion after another, with the results."""

from collections.abc import Callable
from math import inf

from lbr.capability.context import Context
from lbr.leases.client import LeaseClient, LeaseTarget, PendingReply
from lbr.messages.codes import Reason, heard
from lbr.messages.drive import GoalResult
from lbr.messages.joints import JointsCommand, JointsState
from lbr.messages.leases import CommandReply, StopCommand
from lbr.operations.motions import MotionsSettings
from lbr.operations.motions.state import Accepted, Event, JointsEnded, JointsStopped, Lost, Passed

JOINTS = LeaseTarget(
    "move", "halt", "joints operation", "joints operation does not answer; the joints hold by themselves"
)
RENEWAL = JointsCommand()
STOP_S = 1.0


class JointsClient:
    """A client of the joints. `step` calls `happened` with the kernel's events."""

    def __init__(self, ctx: Context[MotionsSettings], happened: Callable[[Event], None]) -> None:
        self._ctx = ctx
        self._happened = happened
        self._lease: LeaseClient | None = None
        self._asked: PendingReply | None = None
        self._first: JointsCommand | None = None
        self._wanted: JointsCommand | None = None
        self._passed = ("", 0)
        self._stopped_s = -inf
        self._feet_s: float | None = None

    @property
    def trouble(self) -> Reason | None:
        """Return why the joints would not follow, or None."""
        names = self._ctx.targets("move")
        gone = names and not any(self._ctx.alive(name) for name in names)
        return Reason("unreachable", f"joints operation ({', '.join(names)}) is not running") if gone else None

    def follow(self, command: JointsCommand) -> None:
        """Send a command in place of the present motion; `Accepted` or `Lost` follows."""
        self._wanted = command
        if self._lease is None:
            self._first = command
            self._lease = LeaseClient(self._ctx, JOINTS, command)
        elif self._first is None:
            self._asked = self._lease.send(command)

    def append(self, command: JointsCommand) -> None:
        """Append a command to the motion."""
        if self._lease is not None:
            self._lease.send(command)

    def halt(self, why: str, *, lost: bool = False, by: str = "", at_once: bool = False) -> None:
        """Stop the joints; `lost`: their mover is gone; `by`: who sent the stop; `at_once`: hold without a step."""
        if self._lease is not None:
            self._lease.release(why, lost=lost, by=by, at_once=at_once)
        elif (by or at_once) and self._feet_s is not None:
            self._ctx.ask("halt", StopCommand(reason=why[:200], by=by[:200], at_once=at_once), STOP_S)
        self.abandon()

    def abandon(self) -> None:
        """Give up the lease without a command."""
        self._lease = self._asked = None
        self._first = self._wanted = None

    def step(self) -> None:
        """Read the joints' messages, and renew the lease."""
        if self._lease is not None:
            self._listen(self._lease)
        for received in self._ctx.take("ended"):
            if isinstance(received.message, GoalResult):
                self._happened(JointsEnded(result=received.message))
        self._look()
        if self._lease is not None and self._lease.renewal_due:
            self._lease.send(RENEWAL)

    def _listen(self, lease: LeaseClient) -> None:
        lease.step()
        if lease.ended or self.trouble:
            self.abandon()
            self._happened(
                Lost(why=lease.ended or Reason("unreachable", f"{self.trouble}; the joints hold by themselves"))
            )
        elif self._first is not None and lease.accepted is not None:
            self._accepted_first(lease, lease.accepted)
        elif self._asked is not None and (answers := self._asked.answers()) is not None:
            self._asked = None
            reply = next(iter(answers.values()), None)
            if isinstance(reply, CommandReply):
                self._happened(Accepted(goal=reply.goal, note=_note(reply)))

    def _accepted_first(self, lease: LeaseClient, reply: CommandReply) -> None:
        """Report the acceptance, or send at once the command that has replaced the first meanwhile."""
        first, self._first = self._first, None
        if self._wanted is first or self._wanted is None:
            self._happened(Accepted(goal=reply.goal, note=_note(reply)))
        else:
            self._asked = lease.send(self._wanted)

    def _look(self) -> None:
        newest = self._ctx.latest("joints")
        state = newest.message if newest is not None else None
        if not isinstance(state, JointsState):
            return
        self._feet_s = state.feet_s
        if state.goal is not None and (state.goal, state.passed) != self._passed:
            self._passed = (state.goal, state.passed)
            self._happened(Passed(goal=state.goal, frames=state.passed))
        if state.stopped_s is not None and state.stopped_s > self._stopped_s:
            self._stopped_s = state.stopped_s
            self._happened(
                JointsStopped(
                    at=state.stopped_s, why=heard(state.code or "stopped", state.reason or "the joints were stopped")
                )
            )


def _note(reply: CommandReply) -> Reason | None:
    return heard(reply.code, reply.reason) if reply.reason else None
