"""Real capabilities in one process, on a stepped clock: their contexts and loops, over a bus in memory.

A message, question or answer of one round arrives in the next. Nothing happens between rounds, and the order is always
the same. An exception of a capability ends the round. A capability that waits for its device does so on its own time
(`spend`), and is busy meanwhile.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, NamedTuple

import msgspec
from msgspec import Raw, Struct

from lbr.bus import keys, wire
from lbr.bus.codec import Decoder
from lbr.bus.memory import BEGAN_S, Memory, MemoryTransport
from lbr.bus.transport import Question
from lbr.capability.base import Capability
from lbr.capability.calls import Answers
from lbr.capability.config import InputWire, OutputWire, ProcessConfig
from lbr.capability.kind import Kind
from lbr.capability.loop import EARLY_S, Garbage, Loop
from lbr.capability.reporter import Phase, Reporter
from lbr.capability.runtime import ProcessContext
from lbr.messages.codes import ReasonCode
from lbr.messages.leases import CommandReply
from lbr.messages.rows import Row, row_set
from lbr.messages.system import EstopRequest, Event

ROUND_S = 0.01
"""One hop over the bus takes up to 7 ms beside four busy loops; a round is a bit longer."""


DEPTH = 1000
"""The number of messages that wait for their reader at a port, for a capability that is alone."""


class Told(NamedTuple):
    """An event, with the time of its arrival; a degraded capability counts as one."""

    at_s: float
    subject: str
    kind: str
    text: str
    code: str


def alone(
    kind: Kind,
    settings: str | bytes = "{}",
    rows: Iterable[Row] = (),
    *,
    robot: str = "robot",
    name: str = "",
) -> ProcessConfig:
    """Return the process of a kind whose ports and requests are wired to capabilities of the same names."""
    given, name = tuple(rows), name or kind.name
    return ProcessConfig(
        robot=robot,
        name=name,
        kind=kind.name,
        settings=Raw(settings.encode() if isinstance(settings, str) else settings),
        simulated=True,
        endpoints=(),
        home="/nonexistent",
        wiring={
            port: (InputWire(key=keys.port(robot, port, port), source=port, history=DEPTH),)
            for port in (*kind.inputs, *kind.setpoints)
        },
        outputs={output: (OutputWire(key=keys.port(robot, name, output)),) for output in kind.outputs},
        requests={request: {request: keys.port(robot, request, request)} for request in kind.requests},
        rows={
            read.row.TABLE: row_set(read.row, (one for one in given if type(one) is read.row)) for read in kind.reads
        },
    )


class StageReporter(Reporter):
    """Keeps a capability's reports: its `phases`, and the rows that it `learnt`."""

    def __init__(self, reported: Callable[[Phase], None]) -> None:
        self._reported = reported
        self.reported = ("", "", "")
        self.phases: list[Phase] = []
        self.rows: list[Mapping[str, msgspec.Raw]] = []

    def phase(self, phase: str, reason: str = "", code: ReasonCode = "") -> None:
        """Keep a change of phase or reason."""
        if (phase, reason, code) != self.reported:
            self.reported = (phase, reason, code)
            self.phases.append(self.reported)
            self._reported(self.reported)

    def learnt(self, rows: Mapping[str, msgspec.Raw]) -> None:
        """Keep rows, without storing them."""
        self.rows.append(rows)

    def beat(self, counts: dict[str, int]) -> None:
        """Do nothing: nobody waits for it."""


class LeftAlone(Garbage):
    """Leaves the times of collection to the caller of the stage."""

    def wait_for_us(self) -> None:
        """Do nothing."""

    def settle(self) -> None:
        """Do nothing."""

    def collect(self, now: float) -> None:
        """Do nothing."""


class Member:
    """A capability on the stage; one that is `frozen` has no rounds."""

    def __init__(self, loop: Loop, ctx: ProcessContext, reporter: StageReporter, opens_s: float) -> None:
        assert loop.capability is not None
        self.loop, self.ctx, self.reporter = loop, ctx, reporter
        self.capability: Capability[Struct] = loop.capability
        self.frozen = False
        self.woken = False
        self._opens_s = self._due_s = opens_s

    def round(self, now: float) -> None:
        """Do the work of its process at this moment, if there is any."""
        due = self.woken or now >= self._due_s - EARLY_S
        if due and not self.frozen and now >= self._opens_s - EARLY_S:
            self.woken = False
            self._due_s = self.loop.step()


class Stage:
    """Capabilities by name, and the bus between them. `told` are the events, and `names` all that count as present."""

    def __init__(self, robot: str = "robot", now: float = BEGAN_S, round_s: float = ROUND_S) -> None:
        self.robot = robot
        self.round_s = round_s
        self.bus = Memory(now)
        self.told: list[Told] = []
        self.members: dict[str, Member] = {}
        self._outside = MemoryTransport(self.bus)
        self._transports: dict[str, list[MemoryTransport]] = {}
        self._seals: dict[str, bytes] = {}
        self._busy_until: dict[str, float] = {}
        self.listen(keys.event(robot), Event, self._keep)

    @property
    def now(self) -> float:
        """Return the time of the stage."""
        return self.bus.now

    def time_of(self, name: str) -> float:
        """Return a capability's own time, in which it may still be waiting for its device."""
        return max(self.bus.clock(), self._busy_until.get(name, 0.0))

    def spend(self, name: str, seconds: float) -> None:
        """Let a capability wait for its device."""
        self._busy_until[name] = self.time_of(name) + seconds

    @property
    def names(self) -> set[str]:
        """Return all names that count as present, including those that are not on the stage."""
        return self.bus.names

    def add(self, config: ProcessConfig, kind: Kind | None = None, phase_s: float = 0.0) -> Capability[Struct]:
        """Add a capability, of an installed kind by default; it opens after `phase_s`."""
        for feeds in config.wiring.values():
            self._seals.update((feed.key, bytes.fromhex(feed.seal)) for feed in feeds)
        reporter = StageReporter(partial(self._reported, config.name))
        loop = Loop(
            config,
            reporter,
            LeftAlone(),
            join=self._join,
            wake=partial(self._wake, config.name),
            kind=kind,
        )
        ctx = loop.begin()
        self.members[config.name] = member = Member(loop, ctx, reporter, self.now + phase_s)
        return member.capability

    def kill(self, name: str) -> None:
        """Remove a capability at once, like a killed process: it closes nothing."""
        del self.members[name]
        for transport in self._transports.pop(name):
            transport.close()

    def close(self) -> None:
        """Close all capabilities in order."""
        for member in self.members.values():
            member.loop.end()
        self.members.clear()

    def listen(self, key: str, message: type[Any], hear: Callable[[Any], None]) -> None:
        """Call `hear` with every message of a key."""
        self.bus.listen(key, message, hear)

    def put(self, key: str, message: Struct, source: str) -> None:
        """Publish as a sender that is not on the stage; a setpoint is sealed as by its source."""
        self.bus.publish(key, message, source, seal=self._seals.get(key, b""))

    def arrive(self, name: str, port: str, message: Struct) -> None:
        """Put a message on an input or setpoint, from the capability that is wired to it."""
        for feed in self.members[name].ctx.config.wiring[port]:
            self.put(feed.key, message, feed.source)

    def hear(self, name: str, output: str) -> list[Any]:
        """Return a list that collects all later messages of an output."""
        heard: list[Any] = []
        self.listen(keys.port(self.robot, name, output), self.members[name].ctx.kind.outputs[output], heard.append)
        return heard

    def press(self, reason: str, source: str = "stage") -> None:
        """Press the emergency stop."""
        self.bus.publish(keys.estop(self.robot), EstopRequest(engaged=True, reason=reason), source)

    def command(self, name: str, what: str, message: object, source: str, timeout_s: float = 2.0) -> Answers:
        """Ask one capability from outside."""
        replies = self.members[name].ctx.kind.replies if name in self.members else {}
        key = keys.port(self.robot, name, what)
        question: Question = self._outside.query(key, wire.encode(message), timeout_s=timeout_s, source=source)
        return Answers({name: question}, Decoder(replies.get(what, CommandReply)))

    def answer(self, name: str, what: str, message: object, source: str = "stage", timeout_s: float = 2.0) -> Any:
        """Ask one capability, and let time pass until it has answered; None if it does not."""
        asked = self.command(name, what, message, source, timeout_s)
        while (answers := asked.answers()) is None:
            self.round()
        return answers[name]

    def round(self) -> None:
        """Let one round pass."""
        self.bus.step(self.round_s)
        for name, member in list(self.members.items()):
            if self.time_of(name) <= self.now + EARLY_S:
                member.round(self.now)

    def run(self, seconds: float, each: Iterable[Callable[[], object]] = ()) -> None:
        """Let time pass, and call `each` in every round."""
        for _ in range(round(seconds / self.round_s)):
            self.round()
            for do in each:
                do()

    def _join(self, config: ProcessConfig, *, alone: bool) -> MemoryTransport:
        del alone
        transport = MemoryTransport(self.bus, partial(self.time_of, config.name))
        self._transports.setdefault(config.name, []).append(transport)
        return transport

    def _wake(self, name: str) -> None:
        if name in self.members:
            self.members[name].woken = True

    def _keep(self, event: Event) -> None:
        self.told.append(Told(self.now, event.subject, event.kind, event.text, event.code))

    def _reported(self, name: str, reported: Phase) -> None:
        phase, reason, code = reported
        if phase == "degraded":
            self.told.append(Told(self.now, name, phase, reason, code))
