"""A capability's real context, on a bus in memory whose other participants are played by a test."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from math import nan
from typing import Any

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.bus import keys, wire
from lbr.bus import stamp as stamps
from lbr.bus.codec import Decoder
from lbr.bus.memory import BEGAN_S, Memory, MemoryTransport
from lbr.bus.transport import Transport
from lbr.capability.calls import Answers
from lbr.capability.config import ProcessConfig
from lbr.capability.estop import EstopLatch
from lbr.capability.kind import Kind
from lbr.capability.runtime import ACKNOWLEDGE_S, ProcessContext
from lbr.capability.stage import StageReporter, alone
from lbr.messages.camera import JpegFrame
from lbr.messages.codes import MEANINGS, Code, Reason
from lbr.messages.leases import CommandReply, refused
from lbr.messages.rows import Row
from lbr.messages.system import Event, Stamp


class FakeEstop(EstopLatch):
    """The latch: a test sets `engaged`, or presses it on the bus; `acknowledged` are the answers, oldest first."""

    def __init__(self, config: ProcessConfig, bus: Transport) -> None:
        super().__init__(config, lambda: None, ACKNOWLEDGE_S, bus)
        self.acknowledged: list[tuple[bool, str]] = []

    def acknowledge(self, *, stopped: bool, reason: str = "") -> None:
        """Answer, and keep the answer."""
        super().acknowledge(stopped=stopped, reason=reason)
        self.acknowledged.append((stopped, reason))


@dataclass
class FakeCall:
    """A command that waits for its `answer`, which it accepts once."""

    name: str
    message: Any
    arrived: float = 0.0
    source: str = "console"
    remote: bool = False
    sender_s: float = nan
    waited_s: float = 0.0
    by: str = ""
    answerable: bool = True
    answer: Any = None

    @property
    def refused(self) -> str:
        """Return why it was refused; empty if it was not, or not yet."""
        return "" if getattr(self.answer, "accepted", True) else str(getattr(self.answer, "reason", "refused"))

    def reply(self, answer: Struct, *, quiet: bool = False) -> None:
        """Keep the answer; a second one is a defect, and so is a refusal with an unknown code."""
        del quiet
        assert self.answer is None, "answered twice"
        if not getattr(answer, "accepted", True):
            answer = answer if getattr(answer, "code", "refused") else replace(answer, code="refused")
            code = getattr(answer, "code", "refused")
            assert code in MEANINGS, f"no code of the list: {code!r}"
        self.answer = answer

    def refuse(self, reason: str | Reason, code: Code = "refused") -> None:
        """Answer as the runtime does."""
        self.reply(refused(reason if isinstance(reason, Reason) else Reason(code, reason)))


class Given:
    """An answered question; None: without an answer."""

    done = True

    def __init__(self, answer: object) -> None:
        self.replies = [] if answer is None else [wire.RawMessage("", wire.encode(answer), b"", 0.0)]


@dataclass
class FakeAsked:
    """A question that was asked, of `only` some or of all; `given` are the answers, None while it waits."""

    request: str
    message: Any
    given: Mapping[str, Any] | None = None
    only: Collection[str] | None = None
    decoder: Decoder[Any] = field(default_factory=lambda: Decoder(CommandReply))

    def answers(self) -> Mapping[str, Any] | None:
        """Return the given answers, decoded from their bytes."""
        if self.given is None:
            return None
        return Answers({name: Given(one) for name, one in self.given.items()}, self.decoder).answers()


class AtOnce(Memory):
    """A bus on a test's clock, where nothing waits for the next round."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        super().__init__()

    def clock(self) -> float:
        """Return the test's time."""
        return self._clock()

    def send(self, deliver: Callable[[], None]) -> None:
        """Do it now."""
        deliver()


class FakeContext(ProcessContext):
    """A capability's context: `now` is the time, `published` and `events` are kept, `arrive` sends it messages.

    A question is answered at once by its request's entry in `replies`; without an entry it waits. `wired` maps a port
    or request to its capability, by default one of the same name. `gone` are dead capabilities, `unwatched` outputs
    without a subscriber. `given` are its rows, of the tables that its kind reads, and `kept` those that it has learnt.
    """

    estop: FakeEstop

    def __init__(self, kind: Kind, settings: Struct | None = None, **given: Any) -> None:
        self.now = BEGAN_S
        self.published: list[tuple[str, Any]] = []
        self.taken_s: list[float] = []
        self.events: list[tuple[str, str]] = []
        self.data: list[dict[str, Any]] = []
        self.levels: list[str] = []
        self.codes: list[str] = []
        self.health: list[str] = []
        self.asked: list[FakeAsked] = []
        self.replies: dict[str, Mapping[str, Any]] = {}
        self.wired: dict[str, tuple[str, ...]] = {}
        self.gone: set[str] = set()
        self.kept: list[Any] = []
        self.latched: list[str] = []
        self.unwatched: set[str] = set()
        self.woken = 0
        self._memory = memory = AtOnce(lambda: self.clock())  # noqa: PLW0108 - a test may replace its clock
        config = alone(kind, b"{}" if settings is None else msgspec.json.encode(settings), name="under_test")
        super().__init__(
            config,
            kind,
            StageReporter(lambda _phase: None),
            wake=lambda: None,
            woken_by_streams=False,
            join=lambda _config, *, alone: MemoryTransport(memory),  # noqa: ARG005
        )
        memory.listen(keys.event(self.robot), Event, self._keep)
        self.estop, self.on_tick, self.given = FakeEstop(config, MemoryTransport(memory)), True, ()
        for name, value in given.items():
            if not hasattr(self, name):
                raise TypeError(f"a context has no '{name}'")
            setattr(self, name, value)

    # For a test: inputs and results.

    @property
    def given(self) -> tuple[Row, ...]:
        """Return its rows, of all tables that its kind reads."""
        return tuple(one for read in self.kind.reads for one in self.rows(read.row))

    @given.setter
    def given(self, rows: Iterable[Row]) -> None:
        self._row_sets = alone(self.kind, rows=rows).rows
        self._rows.clear()

    @property
    def answered(self) -> set[str]:
        """Return the outputs whose latest value answers a `get`."""
        return {output for output in self._outputs if self.config.outputs[output][0].key in self._memory.latest}

    def arrive(
        self, port: str, message: object, *, source: str = "", stamp: Stamp | None = None, late_s: float = 0.0
    ) -> None:
        """Put a message on an input or setpoint, sent `late_s` ago or when it was stamped."""
        payload = message.data if isinstance(message, JpegFrame) else wire.encode(message)
        (feed,), sent_s, who = self.config.wiring[port], self.clock() - late_s, source or port
        stamped = wire.encode(replace(stamp, source=who)) if stamp else stamps.make(who, 0, sent_s=sent_s)
        self._memory.latest[feed.key] = wire.RawMessage(feed.key, payload, stamped, self.clock())
        self._memory.carry(feed.key, payload, stamped)

    def unheard(self, port: str) -> None:
        """Restore the state before the first message of an input."""
        self.take(port)
        self._ports[port].last = None

    def said(self, output: str) -> list[Any]:
        """Return all messages of an output."""
        return [message for name, message in self.published if name == output]

    def told(self, kind: str) -> list[str]:
        """Return the texts of all events of a kind."""
        return [text for name, text in self.events if name == kind]

    def answer(self, request: str, message: object) -> Mapping[str, Any] | None:
        """Return the immediate answer to a question, None: it waits; for tests to replace."""
        del message
        return self.replies.get(request)

    # For the capability: its context, by the test's settings.

    def clock(self) -> float:
        """Return the test's time."""
        return self.now

    def publish(self, output: str, message: Struct, *, taken_s: float | None = None) -> None:
        """Publish and keep it; a value that does not fit its declared type is a defect."""
        super().publish(output, message, taken_s=taken_s)
        assert output not in self._refused_outputs, self.events[-1][1]
        self.published.append((output, message))
        if taken_s is not None:
            self.taken_s.append(taken_s)

    def watched(self, output: str) -> bool:
        """Return whether the output is not in `unwatched`."""
        return output not in self.unwatched

    def wake(self) -> None:
        """Count the call."""
        self.woken += 1

    def sources(self, port: str) -> tuple[str, ...]:
        """Return the name of the wired capability."""
        return self.wired.get(port, (port,))

    def targets(self, request: str) -> tuple[str, ...]:
        """Return the names of the wired capabilities."""
        return self.wired.get(request, (request,))

    def alive(self, capability: str) -> bool:
        """Return whether the capability is not in `gone`."""
        return capability not in self.gone

    def ask(  # type: ignore[override]
        self,
        request: str,
        message: Struct,
        timeout_s: float,
        *,
        only: Collection[str] | None = None,
    ) -> FakeAsked:
        """Keep the question, and answer it as the test has set."""
        del timeout_s
        given = self.answer(request, message)
        if given is not None and only is not None:
            given = {name: reply for name, reply in given.items() if name in only}
        decoder = Decoder(self.kind.replies.get(request, CommandReply))
        self.asked.append(FakeAsked(request, message, given, only, decoder))
        return self.asked[-1]

    def engage_estop(self, reason: str) -> None:
        """Press the emergency stop, and keep the reason."""
        super().engage_estop(reason)
        self.latched.append(reason)

    def learn(self, *rows: Row) -> None:
        """Learn the rows, and keep them."""
        super().learn(*rows)
        self.kept.append(rows)

    def ready(self, reason: str = "") -> None:
        """Report it; `health` becomes "ready"."""
        super().ready(reason)
        self.health.append("ready")

    def warn(self, reason: str | Reason, code: Code = "failed") -> None:
        """Report it, and keep the reason in `health`."""
        super().warn(reason, code)
        self.health.append(str(reason))

    def _keep(self, event: Event) -> None:
        self.codes.append(event.code)
        self.events.append((event.kind, event.text))
        self.data.append(event.data)
        self.levels.append(event.level)
