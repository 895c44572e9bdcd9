"""Says the recorded commands to a robot that runs again, at the times of then, and keeps its answers."""

import contextlib
import threading
from collections import deque
from collections.abc import Iterable, Mapping

import msgspec
from msgspec import Struct

from lbr.apps.recorder.recording.decoding import read_or_none
from lbr.apps.recorder.recording.lines import Command
from lbr.bus import keys, wire
from lbr.bus.session import Session
from lbr.errors import BusError
from lbr.messages.system import EstopRequest

ANSWER_S = 3.0
WAIT_S = 0.02
RENEW_NS = 100_000_000
LONGER_NS = 500_000_000
"""So much longer a goal may take, before its lease is let go as it was in the recording."""


AGAIN_NS = 30_000_000
BUSY = frozenset({"busy", "held"})


class Sent(Struct):
    """A command that was said again: when, by the recording's clock, and what was answered; None: nothing yet."""

    command: Command
    at_ns: int
    renews: bool
    reply: Mapping[str, object] | None = None


class _Result(Struct):
    """As much of a goal's result as is needed."""

    goal: str


class _Leased(Struct):
    """As much of a command as is needed."""

    lease: str = ""


class _Goal(Struct):
    """A goal that a source has: what it is called now, when it ended then, and by what it is renewed."""

    name: str
    ended_ns: int
    begun: Sent
    payload: bytes
    next_ns: int

    @property
    def until_ns(self) -> int:
        """So long it is waited for."""
        return self.ended_ns + LONGER_NS


class Feed:
    """The commands from outside, oldest first; a lease of then is the one that was given for it now.

    `ended` is when each goal of the recording ended: who waited for that then does so now. `results` are streams of
    them.
    """

    def __init__(
        self,
        bus: Session,
        robot: str,
        commands: Iterable[Command],
        stops: Iterable[tuple[int, bool]],
        ended: Mapping[str, int],
        results: Iterable[str],
    ) -> None:
        self.sent: list[Sent] = []
        self.begun_before = 0
        self.late_ns = 0
        self._bus, self._robot = bus, robot
        self._commands = deque(commands)
        self._stops = deque(stops)
        self._woken = threading.Event()
        self._leases: dict[str, str] = {}
        self._ended = ended
        self._results = [wire.Subscription(bus, f"{robot}/{topic}", depth=256) for topic in results]
        self._over: set[str] = set()
        self._again: deque[tuple[int, Sent, bytes]] = deque()
        self._goals: dict[str, _Goal] = {}
        self._waiting: list[tuple[Sent, bytes, wire.PendingQuery]] = []

    def step(self, now_ns: int) -> None:
        """Say what is due, and read answers."""
        self._read_answers(now_ns)
        while self._stops and self._stops[0][0] <= now_ns:
            self._emergency(engaged=self._stops.popleft()[1])
        while self._commands and self._commands[0].at_ns <= now_ns and not self._held(self._commands[0], now_ns):
            command = self._commands.popleft()
            self.late_ns = max(self.late_ns, now_ns - command.at_ns)
            self._send(command, now_ns)
        while self._again and self._again[0][0] <= now_ns:
            _, said, payload = self._again.popleft()
            self._ask(said, payload)
        for source, goal in list(self._goals.items()):
            if goal.name in self._over or now_ns >= goal.until_ns:
                del self._goals[source]
            elif goal.ended_ns <= now_ns and goal.next_ns <= now_ns:
                goal.next_ns = now_ns + RENEW_NS
                self._ask(Sent(goal.begun.command, now_ns, renews=True), goal.payload)

    def finish(self, now_ns: int) -> bool:
        """Read answers; say whether all are there."""
        self._read_answers(now_ns)
        return not self._waiting and not self._again

    def otherwise(self, window_ns: int) -> list[Sent]:
        """Return what was answered otherwise than then; of renewals, what none of about that time was answered like."""
        renewals: dict[tuple[str, str, str], list[tuple[int, object, object]]] = {}
        for sent in self.sent:
            if sent.renews:
                then, now = judged(sent.command.reply), judged(sent.reply)
                renewals.setdefault(_line_of(sent.command), []).append((sent.command.at_ns, then, now))
        differing = []
        for sent in self.sent:
            then, now = judged(sent.command.reply), judged(sent.reply)
            if not sent.command.answerable or then == now:
                continue
            near = [
                each
                for each in renewals.get(_line_of(sent.command), ())
                if abs(each[0] - sent.command.at_ns) <= window_ns
            ]
            if not (sent.renews and (any(each[2] == then for each in near) or any(each[1] == now for each in near))):
                differing.append(sent)
        return differing

    def _held(self, command: Command, now_ns: int) -> bool:
        """Return whether who sends this waited for the end of a goal, which is not there yet."""
        goal = self._goals.get(command.source)
        if goal is None or goal.name in self._over:
            return False
        return goal.ended_ns <= command.at_ns and now_ns < goal.until_ns

    def _send(self, command: Command, now_ns: int) -> None:
        self._await(command.at_ns, now_ns)
        payload, lease = command.payload, _lease_of(command.payload)
        if lease:
            if lease not in self._leases:
                self.begun_before += 1
                return
            payload = msgspec.json.encode(msgspec.json.decode(payload) | {"lease": self._leases[lease]})
        said = Sent(command, now_ns, renews=bool(lease))
        self.sent.append(said)
        self._ask(said, payload)

    def _ask(self, sent: Sent, payload: bytes) -> None:
        command = sent.command
        key = keys.port(self._robot, command.to, command.name)
        with contextlib.suppress(BusError):
            if command.answerable:
                query = wire.PendingQuery(
                    self._bus, key, payload, timeout_s=ANSWER_S, source=command.source, wake=self._woken.set
                )
                self._waiting.append((sent, payload, query))
            else:
                wire.put(self._bus, key, msgspec.Raw(payload), source=command.source, urgent=True)

    def _await(self, at_ns: int, now_ns: int) -> None:
        """Have the answers that were there when this was sent: who sent it knew them, and what comes after is judged by
        it."""
        for said, _payload, query in self._waiting:
            while said.command.answered_ns <= at_ns and not query.replies and not query.done:
                self._woken.clear()
                if not query.replies:
                    self._woken.wait(WAIT_S)
        self._read_answers(now_ns)

    def _read_answers(self, now_ns: int) -> None:
        for stream in self._results:
            for raw in stream.take():
                if (result := read_or_none(raw.payload, _Result)) is not None:
                    self._over.add(result.goal)
        waiting = []
        for sent, payload, query in self._waiting:
            if query.replies:
                sent.reply = read_or_none(query.replies[0].payload, dict[str, object])
                self._answered(sent, payload, now_ns)
            elif not query.done:
                waiting.append((sent, payload, query))
        self._waiting = waiting

    def _answered(self, sent: Sent, payload: bytes, now_ns: int) -> None:
        command, reply = sent.command, sent.reply or {}
        if (given := command.reply.get("lease")) and reply.get("lease"):
            self._leases[str(given)] = str(reply["lease"])
        if self._comes_again(sent, reply, now_ns):
            sent.reply = None
            self._again.append((now_ns + AGAIN_NS, sent, payload))
            return
        then, now = str(command.reply.get("goal", "")), str(reply.get("goal", ""))
        if then in self._ended and now and not sent.renews:
            renewal = msgspec.json.encode(msgspec.json.decode(payload) | {"lease": reply.get("lease", "")})
            self._goals[command.source] = _Goal(now, self._ended[then], sent, renewal, now_ns)

    def _comes_again(self, said: Sent, reply: Mapping[str, object], now_ns: int) -> bool:
        """Return whether it was only too early: what went on for a moment longer than then is over soon."""
        accepted = bool(said.command.reply.get("accepted"))
        return accepted and reply.get("code") in BUSY and now_ns - said.at_ns < LONGER_NS

    def _emergency(self, *, engaged: bool) -> None:
        with contextlib.suppress(BusError):
            if engaged:
                request = EstopRequest(engaged=True, reason="as recorded")
                wire.put(self._bus, keys.estop(self._robot), request, source="lbr replay", urgent=True)
            else:
                key = keys.estop_reset(self._robot)
                wire.PendingQuery(self._bus, key, b"{}", timeout_s=ANSWER_S, source="lbr replay")


def judged(reply: Mapping[str, object] | None) -> tuple[object, object, object]:
    """Return what counts of an answer, whatever leases are called."""
    found = reply or {"accepted": "no answer"}
    return found.get("accepted"), found.get("code", ""), found.get("cause", "")


def _line_of(command: Command) -> tuple[str, str, str]:
    return command.to, command.name, command.source


def _lease_of(payload: bytes) -> str:
    """Return the lease that a command quotes; empty: none, or it cannot be read."""
    found = read_or_none(payload, _Leased)
    return found.lease if found is not None else ""
