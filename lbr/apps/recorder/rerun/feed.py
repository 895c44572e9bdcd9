"""Sends the recorded commands to a rerun robot at their recorded times, and collects the answers."""

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
"""The time by which a goal may take longer before its lease is released as in the recording."""


AGAIN_NS = 30_000_000
BUSY = frozenset({"busy", "held"})


class Sent(Struct):
    """A command sent again: its time by the recording's clock, and its answer, None until it comes."""

    command: Command
    at_ns: int
    renews: bool
    reply: Mapping[str, object] | None = None


class _Result(Struct):
    """The part of a goal's result that the feed reads."""

    goal: str


class _Leased(Struct):
    """The part of a command that the feed reads."""

    lease: str = ""


class _Goal(Struct):
    """The goal of a source: its name in this run, its recorded end, and the payload that renews it."""

    name: str
    ended_ns: int
    begun: Sent
    payload: bytes
    next_ns: int

    @property
    def until_ns(self) -> int:
        """The latest time to wait for its end."""
        return self.ended_ns + LONGER_NS


class Feed:
    """The commands from outside, oldest first; each recorded lease is replaced by the one of this run. `ended` has the
    recorded end of each goal: a source that waited for it then also waits now. `results` are the topics of results."""

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
        """Send what is due, and read answers."""
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
        """Read answers; return whether all have come."""
        self._read_answers(now_ns)
        return not self._waiting and not self._again

    def otherwise(self, window_ns: int) -> list[Sent]:
        """Return the commands with another answer than recorded; a renewal may match any at about that time."""
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
        """Return whether the command's source still waits for the end of a goal, as in the recording."""
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
        """Wait for the answers that the sender of a command had in the recording, as later answers depend on it."""
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
        """Return whether to send the command again: it was refused because a goal lasts a moment longer."""
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
    """Return the parts of an answer to compare; names of leases differ in each run."""
    found = reply or {"accepted": "no answer"}
    return found.get("accepted"), found.get("code", ""), found.get("cause", "")


def _line_of(command: Command) -> tuple[str, str, str]:
    return command.to, command.name, command.source


def _lease_of(payload: bytes) -> str:
    """Return the lease in a command; empty without one, or if it is malformed."""
    found = read_or_none(payload, _Leased)
    return found.lease if found is not None else ""
