"""The process around a kernel that grants leases: emergency stop, driver, holder, waiting commands, and publishing."""

import hashlib
import secrets
from abc import abstractmethod
from collections import deque
from collections.abc import Callable, Mapping
from functools import lru_cache
from math import inf
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from msgspec import Struct
from msgspec.structs import replace

from lbr.capability.base import Capability
from lbr.capability.context import Call, Received
from lbr.capability.kind import STOP
from lbr.leases.client import PendingReply
from lbr.leases.lease import EstopChanged, Happened, LeaseTable, Reply, Result, Setpoint, Stop
from lbr.leases.rules import latched
from lbr.messages.codes import Reason
from lbr.messages.drive import LoopStatistics
from lbr.operations.statistics import Beat, LoopMeter

Answers = Mapping[str, object] | None
MOST_WAITING = 16


class LeasedState(Protocol):
    """The part of a kernel's state that is needed here."""

    @property
    def leases(self) -> LeaseTable[Any]:
        """Return the leases, with the current holder."""


S = TypeVar("S", bound=Struct)
L = TypeVar("L", bound=LeasedState)


class WaitingCommand(NamedTuple):
    """A command that waits for replies of others, and its continuation; that gets None if they do not reply in time."""

    call: Call
    asked: PendingReply
    until: float
    then: Callable[[Answers], None]


class LeasingCapability(Capability[S], Generic[S, L]):
    """The base class around a kernel: every decision is the kernel's, every message passes here.

    `ends` is the reason at the end of the process, `driver` the input with the driver's state, `tick` the event of a
    round. `feeds` are the inputs without which a first command would be refused.
    """

    ends: str
    driver: str = ""
    feeds: tuple[str, ...] = ()
    tick: object
    _state: L
    _loop: LoopStatistics | None = None

    @abstractmethod
    def first(self) -> L:
        """Return the initial state, without a lease."""

    @abstractmethod
    def decide(self, event: Any, now: float) -> tuple[L, tuple[Any, ...]]:
        """Return the kernel's state after an event, and its outputs."""

    def lend(self, call: Call) -> None:
        """Decide any command but a stop."""
        super().command(call)

    @abstractmethod
    def not_at_rest(self) -> str:
        """Return why the emergency stop is not acknowledged yet, or an empty string."""

    def trouble(self) -> Reason | None:
        """Return why a motion would not be followed, or None."""
        return None

    def lacks(self) -> Reason | None:
        """Return why no lease would be granted now, or None: the driver must be ready, and every feed must have a
        message."""
        leases = self._state.leases
        return latched(leases) if leases.estop else self.awaited(*self.feeds) or self.trouble()

    @abstractmethod
    def report(self) -> None:
        """Publish the state, when it is due."""

    def hear(self) -> None:
        """Read the inputs other than the driver's."""

    def driver_seen(self, received: Received) -> object:
        """Return the event for a state of the `driver`, if there is one."""

    def driver_lost(self, names: str) -> object:
        """Return the event for a lost `driver`, if there is one."""

    def holder_gone(self, holder: str) -> object:
        """Return the event for a holder whose process is gone."""
        why = f"the process of {holder} is gone"
        return Stop(source=holder, received=self.ctx.clock(), reason=why, lost=True)

    def begin(self) -> None:
        """Start without a lease."""
        self._state = self.first()
        self.keep_time()
        self._waiting: deque[WaitingCommand] = deque()
        self._driver_at, self._driver_alive = -inf, False
        self._alive_holder = self._pressed_by = ""

    def keep_time(self, after: float | None = None) -> None:
        """Start the rounds of the loop at its current rate: at once, or one period `after` a round."""
        self._beat, self._meter, self._loop = Beat(self.rate_hz, after), LoopMeter(self.rate_hz), None

    def step(self) -> None:
        """Process arrived messages, and do a round when it is due."""
        self.listen()
        self.settle()
        now = self.ctx.clock()
        if self._beat.due(now):
            self._loop = self._meter.round(now) or self._loop
            self.happen(self.tick)
        self.report()

    def command(self, call: Call) -> None:
        """Decide a command now, or after the replies that it needs.

        `lost` in a command from another machine is ignored: its source's name proves nothing.
        """
        self.listen()
        if call.name == STOP:
            message, lost = call.message, call.message.lost and not call.remote
            stop = Stop(
                source=call.source,
                received=call.arrived,
                reason=message.reason,
                lost=lost,
                whole=message.whole,
                own=message.own,
                by="" if call.remote else message.by,
                at_once=message.at_once,
            )
            self.happen(stop, call)
        else:
            self.lend(call)
        self.report()

    def woke(self, slept_s: float) -> None:
        """End every motion from before the computer slept: leases did not expire, since its clock stood still."""
        reason = f"this computer slept for {slept_s:.0f} s"
        self.happen(Stop(source=self.ctx.name, received=self.ctx.clock(), reason=reason))

    def close(self) -> None:
        """Refuse waiting commands, and stop the current motion."""
        while self._waiting:
            self._waiting.popleft().call.refuse(self.ends, "shutting_down")
        self.happen(Stop(source=self.ctx.name, received=self.ctx.clock(), reason=self.ends))
        self.report()

    def listen(self) -> None:
        """Process arrived messages."""
        estop = self.ctx.estop
        if estop.engaged != self._state.leases.estop or (estop.engaged and estop.by != self._pressed_by):
            self._pressed_by = estop.by
            self.happen(EstopChanged(engaged=estop.engaged, reason=estop.reason, by=estop.by))
        if self.driver:
            self._watch_driver(self.driver)
        self._watch_holder()
        self.hear()
        estop.follows = not self.trouble()
        if estop.engaged:
            why_not = self.not_at_rest()
            estop.acknowledge(stopped=not why_not, reason=why_not)

    def wait_for(
        self, call: Call, whom: str, ask: Callable[[], PendingReply], timeout_s: float, then: Callable[[Answers], None]
    ) -> None:
        """Make a command wait for replies of others; waiting commands are decided in the order of their arrival."""
        if len(self._waiting) >= MOST_WAITING:
            call.refuse(f"too many commands wait for {whom}; send fewer", "busy")
            return
        self._waiting.append(WaitingCommand(call, ask(), self.ctx.clock() + 2 * timeout_s, then))
        self.settle()

    def settle(self) -> None:
        """Continue with the commands whose replies have arrived."""
        while self._waiting:
            waiting = self._waiting[0]
            answers = waiting.asked.answers()
            if answers is None and self.ctx.clock() < waiting.until:
                return
            self._waiting.popleft()
            waiting.then(answers)

    def happen(self, event: object, call: Call | None = None) -> None:
        """Have the kernel decide an event, and send its outputs, setpoints before all reports.

        `call` is the command to reply to.
        """
        self._state, outputs = self.decide(event, self.ctx.clock())
        live = self._state.leases.live
        self.ctx.live_lease = live.id if live is not None else ""
        for output in sorted(outputs, key=_is_report):
            self.pass_on(output, call)

    def pass_on(self, output: Any, call: Call | None) -> None:
        """Publish an output, or reply."""
        match output:
            case Setpoint(message=message):
                self.ctx.publish("setpoint", marked(message))
            case Result(message=message):
                self.ctx.publish("result", message)
            case Happened(kind=kind, text=text, level=level, data=data, code=code, about=about):
                self.ctx.event(kind, text, level=level, data=dict(data), code=code, about=about)
            case Reply(message=reply, late=late):
                if call is not None:
                    call.reply(reply, quiet=late)

    def _watch_driver(self, port: str) -> None:
        sources = self.ctx.sources(port)
        alive = any(self.ctx.alive(source) for source in sources)
        if self._driver_alive and not alive:
            self.happen(self.driver_lost(", ".join(sources)))
        self._driver_alive = alive
        newest = self.ctx.latest(port)
        if newest is not None and newest.arrived > self._driver_at:
            self._driver_at = newest.arrived
            self.happen(self.driver_seen(newest))

    def _watch_holder(self) -> None:
        """End the motion of a capability whose process is gone; other holders are known only by their lease."""
        lease = self._state.leases.live
        holder = lease.source if lease is not None else ""
        alive = bool(holder) and self.ctx.alive(holder)
        if holder and holder == self._alive_holder and not alive:
            self.happen(self.holder_gone(holder))
        self._alive_holder = holder if alive else ""


def _is_report(output: object) -> bool:
    return not isinstance(output, Setpoint)


def origin_of(call: Call) -> dict[str, Any]:
    """Return the kernel's fields of a motion from a call: its source, its age, and a fresh lease."""
    return {
        "source": call.source,
        "new_lease": secrets.token_hex(8),
        "received": call.arrived,
        "remote": call.remote,
        "sender_s": call.sender_s,
        "waited_s": call.waited_s,
        "by": call.by,
        "answerable": call.answerable,
    }


def marked(setpoint: Struct) -> Struct:
    """Return a setpoint with a mark in place of its lease: setpoints are public, and a lease is good for any sender."""
    lease = getattr(setpoint, "lease", "")
    return replace(setpoint, lease=mark(lease)) if lease else setpoint


@lru_cache(maxsize=16)
def mark(lease: str) -> str:
    """Return the public mark of a lease, a one-way hash."""
    return hashlib.blake2b(lease.encode(errors="replace"), digest_size=8).hexdigest()


def new_goal() -> str:
    """Return a new name for a goal."""
    return f"goal-{secrets.token_hex(4)}"
