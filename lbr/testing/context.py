"""A capability's context without a bus."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.bus import wire
from lbr.bus.stamp import sent_s
from lbr.capability.context import Call, Context, Device, Received
from lbr.messages.camera import JpegFrame
from lbr.messages.codes import MEANINGS, Code, Reason
from lbr.messages.leases import refused
from lbr.messages.rows import Row
from lbr.messages.system import Stamp

S = TypeVar("S", bound=Struct)
R = TypeVar("R", bound=Row)
BEGAN_S = 100.0
"""Not zero, so that a time that was never set is not mistaken for one that was."""


@dataclass
class FakeEstop:
    """The latch: a test sets `engaged`; `acknowledged` are the answers, oldest first."""

    engaged: bool = False
    reason: str = ""
    by: str = ""
    follows: bool = True
    acknowledged: list[tuple[bool, str]] = field(default_factory=list)

    def acknowledge(self, *, stopped: bool, reason: str = "") -> None:
        """Keep the answer."""
        self.acknowledged.append((stopped, reason))

    def serve(self) -> None:
        """Do nothing: nobody releases this one but the test."""

    def close(self) -> None:
        """Do nothing."""


@dataclass
class FakeCall:
    """A command that waits for its `answer`, which it takes once."""

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
        """Why it was refused; empty if it was not, or not yet."""
        return "" if getattr(self.answer, "accepted", True) else str(getattr(self.answer, "reason", "refused"))

    def reply(self, answer: Struct, *, quiet: bool = False) -> None:
        """Keep the answer; a second one is a defect, and so is a refusal whose code is not on the list."""
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


@dataclass
class FakeAsked:
    """A question that was put, to `only` some or to all; `given` are the answers by capability, None while it waits."""

    request: str
    message: Any
    given: Mapping[str, Any] | None = None
    only: Collection[str] | None = None

    def answers(self) -> Mapping[str, Any] | None:
        """Return what was given."""
        return self.given


class FakeContext(Generic[S]):
    """A capability's context: `now` is the time, `published` and `events` are kept, `arrive` is what it hears.

    A question is answered with what stands in `replies` for its request, at once; without an entry it waits. Who is wired
    to a port or request stands in `wired`, by default one of that name; who is dead, in `gone`; which outputs have no
    subscriber, in `unwatched`. `given` are its rows, of
    whatever tables, and `kept` what it has learnt. Any attribute of `Context` may be given by its name.
    """

    robot = "robot"
    name = "under_test"
    simulated = True
    device: Device | None = None
    devices: tuple[Device, ...] = ()
    home = "/nonexistent"
    given: tuple[Row, ...] = ()
    on_tick = True
    live_lease = ""

    def __init__(self, settings: S, **given: Any) -> None:
        for name, value in given.items():
            if not hasattr(type(self), name):
                raise TypeError(f"a context has no '{name}'")
            setattr(self, name, value)
        self.settings = settings
        self.estop = FakeEstop()
        self.now = BEGAN_S
        self.published: list[tuple[str, Any]] = []
        self.taken_s: list[float] = []
        self.answered: dict[str, Any] = {}
        self.events: list[tuple[str, str]] = []
        self.data: list[dict[str, Any] | None] = []
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
        self._latest: dict[str, Received] = {}
        self._arrived: dict[str, list[Received]] = {}

    # What a test does and looks at.

    def arrive(
        self, port: str, message: Any, *, source: str = "", stamp: Stamp | None = None, late_s: float = 0.0
    ) -> None:
        """Have a message come on an input or setpoint, sent `late_s` ago or when its stamp says."""
        came = Received(message, stamp, sent_s(stamp, self.clock() - late_s), source or port)
        self._latest[port] = came
        self._arrived.setdefault(port, []).append(came)

    def unheard(self, port: str) -> None:
        """Have it be as before the first message of an input."""
        self._latest.pop(port, None)
        self._arrived.pop(port, None)

    def said(self, output: str) -> list[Any]:
        """Return all that was published on an output."""
        return [message for name, message in self.published if name == output]

    def told(self, kind: str) -> list[str]:
        """Return the texts of all events of a kind."""
        return [text for name, text in self.events if name == kind]

    def answer(self, request: str, message: Any) -> Mapping[str, Any] | None:
        """Return what a question is answered with at once, None: it waits; for tests to replace."""
        del message
        return self.replies.get(request)

    # What the capability sees.

    def clock(self) -> float:
        """Return the test's time."""
        return self.now

    def publish(self, output: str, message: Struct, *, taken_s: float | None = None) -> None:
        """Keep it; a value that its declared type does not allow is a defect."""
        if not isinstance(message, JpegFrame):
            msgspec.json.decode(wire.encode(message), type=type(message))
        self.published.append((output, message))
        self.answered[output] = message
        if taken_s is not None:
            self.taken_s.append(taken_s)

    def forget(self, output: str) -> None:
        """Answer no `get` any more."""
        self.answered.pop(output, None)

    def watched(self, output: str) -> bool:
        """Say what the test has set in `unwatched`."""
        return output not in self.unwatched

    def wake(self) -> None:
        """Count it."""
        self.woken += 1

    def latest(self, port: str) -> Received | None:
        """Return what arrived last."""
        return self._latest.get(port)

    def take(self, port: str) -> list[Received]:
        """Return what arrived since the last call."""
        return self._arrived.pop(port, [])

    def sources(self, port: str) -> tuple[str, ...]:
        """Return who is wired there."""
        return self.wired.get(port, (port,))

    def targets(self, request: str) -> tuple[str, ...]:
        """Return who is wired there."""
        return self.wired.get(request, (request,))

    def alive(self, capability: str) -> bool:
        """Say whether the test lets it live."""
        return capability not in self.gone

    def ask(self, request: str, message: Struct, timeout_s: float, *, only: Collection[str] | None = None) -> FakeAsked:
        """Keep the question, and answer it as the test says."""
        del timeout_s
        given = self.answer(request, message)
        if given is not None and only is not None:
            given = {name: reply for name, reply in given.items() if name in only}
        self.asked.append(FakeAsked(request, message, given, only))
        return self.asked[-1]

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
        """Keep it, with its data, level and code."""
        del about
        self.codes.append(code)
        self.events.append((kind, text))
        self.data.append(data)
        self.levels.append(level)

    def engage_estop(self, reason: str) -> None:
        """Keep the reason."""
        self.latched.append(reason)

    def rows(self, row: type[R]) -> tuple[R, ...]:
        """Return the rows of a table, of those that are given."""
        return tuple(one for one in self.given if type(one) is row)

    def learn(self, *rows: Row) -> None:
        """Go on with them, as the runtime does."""
        self.kept.append(rows)
        self.adopt(rows)

    def adopt(self, rows: Iterable[Row]) -> None:
        """Go on with them, as the runtime does."""
        self.given = tuple({(one.TABLE, one.key): one for one in (*self.given, *rows)}.values())

    def ready(self, reason: str = "") -> None:
        """Keep that it works: `health` says "ready"."""
        del reason
        self.health.append("ready")

    def warn(self, reason: str | Reason, code: Code = "failed") -> None:
        """Keep why it works, but not as it should; the last code is in `health_code`."""
        self.health.append(str(reason))
        self.health_code = reason.code if isinstance(reason, Reason) else code


if TYPE_CHECKING:

    def _is_a_context(fake: FakeContext[S], call: FakeCall) -> tuple[Context[S], Call]:
        return fake, call
