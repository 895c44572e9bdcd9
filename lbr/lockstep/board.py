"""The bus of a robot in lockstep: capabilities as they are run, by a clock of its own, in an order that is always the same.

What is published, asked or answered in one round is there in the next. That is late, as on a busy machine.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping
from math import nan
from typing import Any, NamedTuple, TypeVar, cast

import msgspec
from msgspec import Struct

from lbr.bus import keys
from lbr.bus.stamp import Origin
from lbr.capability.base import Capability
from lbr.capability.config import InputWire, ProcessConfig
from lbr.capability.context import Context, Device, Received
from lbr.capability.estop import NothingToStop
from lbr.capability.kind import STOP, Kind
from lbr.messages.codes import Code, Reason
from lbr.messages.leases import refused
from lbr.messages.rows import Row, by_table, with_rows
from lbr.messages.system import Stamp

R = TypeVar("R", bound=Row)
ROUND_S = 0.01
"""One hop over the bus takes up to 7 ms beside four busy loops; a round is a bit more."""
MOMENT_S = 1e-6
FULL_S = 1e-9
"""Rounds are added up: what is due at the end of one is due then."""


class Told(NamedTuple):
    """An event, with when it was told."""

    at_s: float
    subject: str
    kind: str
    text: str
    code: str


class Asked:
    """A command on its way to a capability, and back."""

    remote = False
    sender_s = nan
    answerable = True

    def __init__(self, board: "Board", name: str, message: Any, source: str, origin: Origin | None = None) -> None:
        self.name = name
        self.message = message
        self.source = source
        self.arrived = board.moment()
        self.by, self.waited_s = (origin.source, self.arrived - origin.written_s) if origin is not None else ("", 0.0)
        self.answer: Any = None
        self.answered_s = nan
        self._board = board

    def reply(self, answer: Struct, *, quiet: bool = False) -> None:
        """Answer, once."""
        del quiet
        if self.answer is None:
            self.answer, self.answered_s = answer, self._board.now

    def refuse(self, reason: str | Reason, code: Code = "refused") -> None:
        """Answer that it is not accepted, and why."""
        self.reply(refused(reason if isinstance(reason, Reason) else Reason(code, reason)))

    @property
    def back(self) -> bool:
        """Return whether the answer is there."""
        return self._board.now > self.answered_s


class Question:
    """What was asked of several; who is not on the board gives no answer."""

    def __init__(self, board: "Board", asked: Mapping[str, Asked | None], timeout_s: float) -> None:
        self._board = board
        self._asked = asked
        self._until = board.now + timeout_s

    def answers(self) -> dict[str, Any] | None:
        """Return each answer, None while one is awaited."""
        late = self._board.now >= self._until
        if not late and any(one is not None and not one.back for one in self._asked.values()):
            return None
        return {name: one.answer if one is not None and one.back else None for name, one in self._asked.items()}


class Port:
    """What came on an input or setpoint."""

    def __init__(self, wires: tuple[InputWire, ...]) -> None:
        self.sources = tuple(wire.source for wire in wires)
        self.last: Received | None = None
        self._fresh: deque[Received] = deque(maxlen=max((wire.history for wire in wires), default=1))
        self._next: dict[str, float] = {}

    def bring(self, wire: InputWire, received: Received, now: float) -> bool:
        """Take a message, unless it comes sooner than the channel wants it."""
        if wire.rate_hz is not None:
            if now < self._next.get(wire.key, now):
                return False
            self._next[wire.key] = now + 0.9 / wire.rate_hz
        self.last = received
        self._fresh.append(received)
        return True

    def take(self) -> list[Received]:
        """Return what is new, oldest first."""
        fresh = list(self._fresh)
        self._fresh.clear()
        return fresh


class BoardContext:
    """A capability's context on the board."""

    simulated = True

    def __init__(self, board: "Board", config: ProcessConfig, kind: Kind) -> None:
        self.robot, self.name, self.home = config.robot, config.name, config.home
        self.settings = kind.parse(config.settings)
        self.devices = tuple(Device(d.name, d.type, d.address, d.settings) for d in config.devices)
        self.device = next((d for d in self.devices if d.name == config.device), None)
        self.on_tick = True
        self.live_lease = ""
        self.estop = NothingToStop()
        self.woken = False
        self.ports = {name: Port(config.wiring.get(name, ())) for name in (*kind.inputs, *kind.setpoints)}
        self._board = board
        self._config = config
        self._row_sets = config.rows

    def rows(self, row: type[R]) -> tuple[R, ...]:
        """Return the rows of a table that the kind reads."""
        return tuple(cast("list[R]", msgspec.json.decode(self._row_sets[row.TABLE].rows, type=list[row])))  # type: ignore[valid-type]

    def clock(self) -> float:
        """Return the board's time."""
        return self._board.now

    def publish(self, output: str, message: Struct, *, taken_s: float | None = None) -> None:
        """Have it there in the next round, as sent now, or when it was taken."""
        for wire in self._config.outputs[output]:
            self._board.put(wire.key, message, self.name, sent_s=taken_s)

    def forget(self, output: str) -> None:
        """Do nothing: nobody asks for what was."""

    def watched(self, output: str) -> bool:
        """Say that nobody looks at pictures."""
        del output
        return False

    def wake(self) -> None:
        """Have a step in the next round."""
        self.woken = True

    def latest(self, port: str) -> Received | None:
        """Return the newest message of an input."""
        return self.ports[port].last

    def take(self, port: str) -> list[Received]:
        """Return what arrived since the last call."""
        return self.ports[port].take()

    def sources(self, port: str) -> tuple[str, ...]:
        """Return who is wired to an input."""
        return self.ports[port].sources

    def alive(self, capability: str) -> bool:
        """Say whether it is on the board."""
        return capability in self._board.names

    def targets(self, request: str) -> tuple[str, ...]:
        """Return who is wired to a request."""
        return tuple(self._config.requests.get(request, {}))

    def ask(
        self,
        request: str,
        message: Any,
        timeout_s: float,
        *,
        only: Collection[str] | None = None,
        origin: Origin | None = None,
    ) -> Question:
        """Ask those that are wired to a request."""
        wired = self._config.requests.get(request, {})
        asked = {n: k for n, k in wired.items() if only is None or n in only}
        return self._board.ask(asked, message, self.name, timeout_s, origin)

    def event(
        self,
        kind: str,
        text: str,
        *,
        level: str = "info",
        data: dict[str, Any] | None = None,
        code: str = "",
        about: str = "",
    ) -> None:
        """Keep what is told."""
        del level, data, about
        self._board.told.append(Told(self._board.now, self.name, kind, text, code))

    def engage_estop(self, reason: str) -> None:
        """Keep that it was asked for; nothing here latches."""
        self.event("estop", reason, code="estop")

    def learn(self, *rows: Row) -> None:
        """Go on with rows that the kind learns; nothing is written down."""
        self.adopt(rows)

    def adopt(self, rows: Iterable[Row]) -> None:
        """Go on with rows."""
        self._row_sets = with_rows(self._row_sets, by_table(rows))

    def ready(self, reason: str = "") -> None:
        """Do nothing: what is here works."""

    def warn(self, reason: str | Reason, code: Code = "failed") -> None:
        """Keep why it does not work as it should."""
        self.event("degraded", str(reason), code=reason.code if isinstance(reason, Reason) else code)


class Member:
    """A capability on the board, with the commands that wait for it."""

    def __init__(self, capability: Capability[Any], ctx: BoardContext, phase_s: float) -> None:
        self.capability = capability
        self.ctx = ctx
        self.calls: deque[Asked] = deque()
        self.due_s = ctx.clock() + phase_s
        self.by_streams = getattr(capability, "woken_by_streams", True)

    def round(self, now: float) -> None:
        """Do what the runtime does in a round, if this is one: commands, stops first, then a step."""
        ctx = self.ctx
        ctx.on_tick = now >= self.due_s - FULL_S
        if not (ctx.on_tick or ctx.woken):
            return
        ctx.woken = False
        if ctx.on_tick:
            period_s = 1.0 / self.capability.rate_hz
            self.due_s = self.due_s + period_s if now < self.due_s + period_s else now + period_s
        calls, self.calls = sorted(self.calls, key=lambda call: call.name != STOP), deque()
        for call in calls:
            self.capability.command(call)
        self.capability.step()
        self.due_s = min(self.due_s, now + 1.0 / self.capability.rate_hz)  # it may have begun something


class Board:
    """Capabilities by name, and what goes between them. `names` are all that count as alive, `told` the events."""

    def __init__(self, robot: str, now: float = 100.0) -> None:
        self.robot = robot
        self.now = now
        self.names: set[str] = set()
        self.told: list[Told] = []
        self.members: dict[str, Member] = {}
        self._wires: dict[str, list[tuple[BoardContext, str, InputWire]]] = {}
        self._listeners: dict[str, list[Callable[[Any], None]]] = {}
        self._sent: list[tuple[str, Received]] = []
        self._asked: list[tuple[str, Asked]] = []
        self._waking: list[Asked] = []
        self._moment = now

    def add(self, config: ProcessConfig, kind: Kind, phase_s: float) -> Capability[Any]:
        """Have a capability live here; its first round is due after `phase_s`."""
        ctx = BoardContext(self, config, kind)
        checked: Context[Any] = ctx
        capability: Capability[Any] = kind.load()(checked)
        self.members[config.name] = Member(capability, ctx, phase_s)
        self.names.add(config.name)
        for port, wires in config.wiring.items():
            for wire in wires if port in ctx.ports else ():
                self._wires.setdefault(wire.key, []).append((ctx, port, wire))
        return capability

    def open(self) -> None:
        """Open them all."""
        for member in self.members.values():
            member.capability.open()

    def listen(self, key: str, hear: Callable[[Any], None]) -> None:
        """Have something hear every message of a key."""
        self._listeners.setdefault(key, []).append(hear)

    def put(self, key: str, message: Any, source: str, *, sent_s: float | None = None) -> None:
        """Have a message there in the next round."""
        if key in self._wires or key in self._listeners:
            self._sent.append((key, Received(message, _NO_STAMP, self.now if sent_s is None else sent_s, source)))

    def ask(
        self, wired: Mapping[str, str], message: Any, source: str, timeout_s: float, origin: Origin | None = None
    ) -> Question:
        """Ask capabilities by the keys of their commands."""
        asked: dict[str, Asked | None] = {}
        for name, key in wired.items():
            asked[name] = None
            if name in self.members:
                call = asked[name] = Asked(self, key.rpartition("/")[2], message, source, origin)
                self._asked.append((name, call))
        return Question(self, asked, timeout_s)

    def command(self, name: str, what: str, message: Any, source: str, timeout_s: float = 2.0) -> Question:
        """Ask one capability from outside."""
        return self.ask({name: keys.port(self.robot, name, what)}, message, source, timeout_s)

    def moment(self) -> float:
        """Return a moment of this round that is later than all before: of two commands one is the newer."""
        self._moment = max(self._moment + MOMENT_S, self.now)
        return self._moment

    def round(self) -> None:
        """Let one round go by."""
        self.now += ROUND_S
        self._deliver()
        for member in self.members.values():
            member.round(self.now)

    def _deliver(self) -> None:
        sent, self._sent = self._sent, []
        for key, received in sent:
            for ctx, port, wire in self._wires.get(key, ()):
                if ctx.ports[port].bring(wire, received, self.now):
                    ctx.woken = ctx.woken or self.members[ctx.name].by_streams
            for hear in self._listeners.get(key, ()):
                hear(received.message)
        asked, self._asked = self._asked, []
        for name, call in asked:
            self.members[name].calls.append(call)
            self.members[name].ctx.woken = True
        self._waking = [call for call in (*self._waking, *(call for _, call in asked)) if not self._woke(call)]

    def _woke(self, call: Asked) -> bool:
        """Wake who asked, once the answer is back."""
        if call.back and call.source in self.members:
            self.members[call.source].ctx.woken = True
        return call.back


_NO_STAMP: Stamp | None = None
