"""Motion borrowed from a capability: requested, renewed at 10 Hz, watched, and given up once it is lost.

All borrowers use this client: a capability by its request ports, a program by its session on the bus.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import Any, Protocol

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.codes import Reason, heard
from lbr.messages.drive import GoalResult
from lbr.messages.leases import CommandReply, StopCommand

RENEW_S = 0.1
SILENT_S = 0.5
"""A lender that answers nothing for this long is silent. A round of ours counts as `RENEW_S` at most: while this
process was delayed it neither asked nor read. Then only the lease shows whether that was too long."""
ANSWER_S = 1.0
MOST_WAITING = 8
MOST_RESULTS = 8
LONGEST_REASON = 200
PLANNED = frozenset({"reached", "interval"})

Message = Struct | Mapping[str, object]


class PendingReply(Protocol):
    """A question under way."""

    def answers(self) -> Mapping[str, Any] | None:
        """Return the answers by capability (None for one that did not answer); None while waiting."""


class Transport(Protocol):
    """The means of a client to ask: a capability's context, or `lbr.leases.over_session.OverSession`."""

    def ask(self, request: str, message: Any, timeout_s: float) -> PendingReply:
        """Ask by a request port."""

    def clock(self) -> float:
        """Return monotonic seconds."""


@dataclass(frozen=True, slots=True)
class LeaseTarget:
    """The lender: the requests to move and to halt it, its kind, and a text about its silence.

    Without a request to halt it, unwanted motion ends with its lease. When a lease ends, the result with the reason may
    come up to `result_s` later.
    """

    motion: str
    halt: str = ""
    kind: str = "mover"
    silent: str = "it does not answer; what moved has stopped by itself"
    silent_s: float = SILENT_S
    result_s: float = 0.0


class LeaseClient:
    """A lease: requested with the `first` motion, or one that was `given`. `step` and `keep` it ten times a second.

    `accepted` is the answer to the request, `result` the result of its goal, and `ended` the reason for the lease's
    end. `silent`: it ended because nobody answers.
    """

    def __init__(
        self,
        transport: Transport,
        target: LeaseTarget,
        first: Message | None = None,
        *,
        given: CommandReply | None = None,
    ) -> None:
        self.ended: Reason | None = None
        self.result: GoalResult | None = None
        self.accepted = given
        self.silent = False
        self._transport = transport
        self._target = target
        self._goal = given.goal if given is not None else ""
        self._last: Message | None = None
        self._sent = self._looked = nan
        self._unheard_s = 0.0
        self._lost: tuple[Reason, float] | None = None
        self._results: dict[str, GoalResult] = {}
        self._asked: list[tuple[PendingReply, bool]] = []
        self._taking = transport.ask(target.motion, first or {}, ANSWER_S) if given is None else None

    @property
    def holds(self) -> bool:
        """Return whether the lease permits to send motion."""
        return self.accepted is not None and self.ended is None and self._lost is None

    @property
    def renewal_due(self) -> bool:
        """Return whether it is time to renew the lease."""
        return self.holds and not self._transport.clock() - self._sent < RENEW_S

    @property
    def lost(self) -> bool:
        """Return whether it may not go on, even while it waits for the result with the reason."""
        return self._lost is not None

    @property
    def good(self) -> bool:
        """Return whether its goal ended as planned."""
        return self.result is not None and self.result.result in PLANNED

    def step(self) -> None:
        """Read the answers."""
        if self.ended is not None:
            return
        if self._taking is not None:
            self._take(self._taking)
        now = self._transport.clock()
        self._unheard_s += min(RENEW_S, now - self._looked)  # this way round, NaN counts as RENEW_S
        self._looked = now
        for asked, vital in [(asked, vital) for asked, vital in self._asked if asked.answers() is not None]:
            self._asked.remove((asked, vital))
            self._read(asked, now, vital=vital)
        self._look_for_the_end(now)

    def keep(self, message: Message) -> None:
        """Send the motion if it is new, or when the lease has to be renewed."""
        if self.renewal_due or (self.holds and message != self._last):
            self.send(message)

    def send(self, message: Message, *, vital: bool = True) -> PendingReply | None:
        """Renew or change the motion; return None, without sending, if too many answers are outstanding.

        If a message that is not `vital` is refused, the motion goes on as before.
        """
        if self.accepted is None or not self.holds or len(self._asked) >= MOST_WAITING:
            return None
        self._sent, self._last = self._transport.clock(), message
        lease = self.accepted.lease
        quoting = replace(message, lease=lease) if isinstance(message, Struct) else {**message, "lease": lease}
        asked = self._transport.ask(self._target.motion, quoting, ANSWER_S)
        self._asked.append((asked, vital))
        return asked

    def hear(self, result: GoalResult) -> None:
        """Note the result of a goal, of anyone's."""
        self._results[result.goal] = result
        if len(self._results) > MOST_RESULTS:
            self._results.pop(next(iter(self._results)))

    def release(self, why: str, *, lost: bool = False, by: str = "", at_once: bool = False) -> PendingReply | None:
        """Halt the borrowed motion, if it is ours or may become so.

        `lost`: its sender is gone. `by` stopped it. `at_once`: without a step to its feet.
        """
        if self.ended is not None:
            return None
        self.ended = Reason("cancelled", why)
        return self._halt(why, lost=lost, by=by, at_once=at_once)

    def _take(self, taking: PendingReply) -> None:
        answers = taking.answers()
        if answers is None:
            return
        self._taking = None
        target, reply = self._target, next(iter(answers.values()), None)
        if len(answers) != 1:
            wired = f"'{target.motion}' must be wired to one {target.kind} by a channel row, and is to {len(answers)}"
            self.ended = Reason("wiring", wired)
        elif not isinstance(reply, CommandReply):
            self.ended, self.silent = Reason("unreachable", f"'{next(iter(answers))}' does not answer"), True
        elif not (reply.accepted and reply.lease):
            self.ended = reply.why
        else:
            self.accepted, self._goal, self._unheard_s = reply, reply.goal, 0.0

    def _read(self, asked: PendingReply, now: float, *, vital: bool) -> None:
        for reply in (asked.answers() or {}).values():
            if not isinstance(reply, CommandReply):
                continue
            self._unheard_s = 0.0
            if reply.accepted:
                self._goal = reply.goal or self._goal
            elif vital or reply.code == "dead_lease":
                self._refused(reply, now)

    def _refused(self, reply: CommandReply, now: float) -> None:
        """Give up. A refused change halts the earlier motion; the reason is the refusal, not the result of the halt."""
        if self._lost is None:
            if reply.code != "dead_lease":
                self._halt(reply.why.text)
                self._goal = ""
            self._lost = (reply.why, now)

    def _look_for_the_end(self, now: float) -> None:
        self.result = self._results.get(self._goal) if self._goal else None
        if self.result is not None:
            self.ended = heard(self.result.code, self.result.reason or self.result.result)
        elif self._lost is not None and not (self._goal and now - self._lost[1] < self._target.result_s):
            self.ended = self._lost[0]
        elif (self.holds and not self._unheard_s <= self._target.silent_s) or (
            self._taking is not None and not self._unheard_s <= ANSWER_S + self._target.silent_s
        ):
            self.ended, self.silent = Reason("unreachable", self._target.silent), True

    def _halt(self, why: str, *, lost: bool = False, by: str = "", at_once: bool = False) -> PendingReply | None:
        if not self._target.halt:
            return None
        reason, by = why[:LONGEST_REASON], by[:LONGEST_REASON]
        stop = StopCommand(reason=reason, lost=lost, by=by, own=True, at_once=at_once)
        return self._transport.ask(self._target.halt, stop, ANSWER_S)
