"""Moving the head: the joints are borrowed while it has a way to go, and are anybody's while it rests.

A lease of the joints ends when they arrive. What tells an arrival from a stop is the result that joints operation gives;
and it is asked again only on the strength of a state of the joints that knows of no stop since.
"""

from math import inf
from typing import NamedTuple, Protocol

from lbr.apps.tracking.control import Angles
from lbr.capability.context import Asked, Received
from lbr.capability.loan import Asking, Lender, Loan
from lbr.messages.drive import GoalResult
from lbr.messages.joints import JointsCommand, JointsState
from lbr.messages.leases import CommandReply

JOINTS = Lender("move", "halt", "joints operation", "joints operation does not answer; the head holds by itself")
RENEWAL = JointsCommand()
HELD = "held by "
EVERY_S = 1.0 / 15.0
RESULT_S = 0.5
"""So long the result of a motion may be behind the end of its lease."""
CURRENT_S = 0.5
SILENT_S = 2.0
MOST_RESULTS = 16


class Context(Asking, Protocol):
    """What is needed of a context."""

    name: str

    def latest(self, port: str) -> Received | None:
        """Return the newest message of an input."""

    def take(self, port: str) -> list[Received]:
        """Return what arrived on an input."""


class Neck(NamedTuple):
    """The names of the two joints, how fast they may turn, and how strong they are meanwhile."""

    yaw: str
    pitch: str
    speed_rps: float
    torque: float


class Mover:
    """`ended` says why the head is not ours to move any more, `waiting` why it is not now; or nothing."""

    def __init__(self, ctx: Context, neck: Neck) -> None:
        self.ended = ""
        self.waiting = ""
        self.began = False
        self._ctx = ctx
        self._neck = neck
        self._since = ctx.clock()
        self._loan: Loan | None = None
        self._over_since = -inf
        self._asked: Asked | None = None
        self._goal = ""
        self._results: dict[str, GoalResult] = {}
        self._wanted: Angles | None = None
        self._sent: Angles | None = None
        self._accepted: Angles | None = None
        self._sent_at = -inf

    def aim(self, angles: Angles) -> None:
        """Look there from now on."""
        self._wanted = angles

    def step(self) -> None:
        """Read what the joints say, and ask for what is wanted."""
        self._listen()
        if self.ended or self._wanted is None:
            return
        if self._loan is None:
            self._take(self._wanted)
        else:
            self._go_on(self._loan, self._wanted)

    def release(self, why: str) -> None:
        """Have the joints hold, if they are still ours."""
        if self._loan is not None:
            self._loan.release(why)
        self._loan = None
        self.ended = self.ended or why

    def _listen(self) -> None:
        for received in self._ctx.take("ended"):
            result: GoalResult = received.message
            self._results[result.goal] = result
            if len(self._results) > MOST_RESULTS:
                del self._results[next(iter(self._results))]
        state = self._state()
        if state is not None and state.stopped_s is not None and state.stopped_s > self._since:
            self._lose(state.reason or "the joints were stopped")
        if self._loan is not None and not self.ended:
            self._loan.step()
            self._read(self._loan)

    def _read(self, loan: Loan) -> None:
        if loan.granted is not None and not self._goal:
            self.began = True
            self._goal, self._accepted = loan.granted.goal, self._sent
        if self._asked is not None and (answers := self._asked.answers()) is not None:
            reply = next(iter(answers.values()), None)
            if isinstance(reply, CommandReply) and reply.accepted:
                self._goal, self._accepted = reply.goal or self._goal, self._sent
            self._asked = None
        if loan.ended:
            self._over(loan)

    def _over(self, loan: Loan) -> None:
        """Find out what it means that a lease is no more: the head has arrived, or somebody else has a say."""
        now, result = self._ctx.clock(), self._results.get(self._goal)
        if loan.granted is None and self.began and HELD in loan.ended:
            self.waiting = loan.ended
            self._rest(now)
        elif loan.granted is None:
            self._lose(loan.ended)
        elif result is not None and result.result == "reached":
            self._rest(now)
        elif result is not None:
            self._lose(result.reason or loan.ended)
        elif not now - self._over_since < RESULT_S:
            if self._over_since == -inf:
                self._over_since = now
            else:
                self._lose(loan.ended)

    def _rest(self, now: float) -> None:
        """The joints are anybody's; what they have not been seen to accept is asked for anew."""
        self._loan = self._asked = None
        self._goal, self._over_since = "", -inf
        self._sent, self._sent_at = self._accepted, now

    def _lose(self, why: str) -> None:
        self.ended = self.ended or why
        self._loan = None

    def _take(self, wanted: Angles) -> None:
        """Borrow the joints, unless the head looks there already or somebody else has them."""
        now, received = self._ctx.clock(), self._ctx.latest("joints")
        if received is None or not received.age_s(now) < SILENT_S:
            self._lose("joints operation does not tell where the joints are; the head holds by itself")
            return
        if (wanted == self._sent and not self.waiting) or not self._sent_at < received.arrived > now - CURRENT_S:
            return
        holder = received.message.holder
        if holder is not None and holder != self._ctx.name and self.began:
            self.waiting = f"{HELD}{holder}"
            return
        self.waiting = ""
        self._loan = Loan(self._ctx, JOINTS, self._command(wanted, asked_s=received.arrived))
        self._mark(wanted)

    def _go_on(self, loan: Loan, wanted: Angles) -> None:
        if not loan.holds:
            return
        if wanted != self._sent and self._ctx.clock() - self._sent_at >= EVERY_S:
            asked = loan.send(self._command(wanted))
            if asked is not None:
                self._asked = asked
                self._mark(wanted)
        elif loan.due:
            loan.send(RENEWAL)

    def _mark(self, wanted: Angles) -> None:
        self._sent, self._sent_at = wanted, self._ctx.clock()

    def _command(self, wanted: Angles, asked_s: float | None = None) -> JointsCommand:
        """Return the way there; the first of a lease gives the joints their strength."""
        return JointsCommand(
            positions={self._neck.yaw: wanted.yaw_rad, self._neck.pitch: wanted.pitch_rad},
            join=True,
            speed_rps=self._neck.speed_rps,
            torque=self._neck.torque if asked_s is not None else None,
            asked_s=asked_s,
        )

    def _state(self) -> JointsState | None:
        received = self._ctx.latest("joints")
        return received.message if received is not None and isinstance(received.message, JointsState) else None
