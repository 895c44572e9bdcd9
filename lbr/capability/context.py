"""The robot as a running capability sees it: settings, wiring, bus and emergency stop."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

from msgspec import Struct

from lbr.capability.tap import Tap
from lbr.leases.client import PendingReply
from lbr.messages.codes import Code, Reason
from lbr.messages.rows import Row
from lbr.messages.schema import JsonObject
from lbr.messages.system import Stamp

R = TypeVar("R", bound=Row)
S_co = TypeVar("S_co", bound=Struct, covariant=True)


class Received(Struct, frozen=True):
    """A message with its stamp, if it has one, and when it was sent, otherwise when it arrived, on our clock."""

    message: Any
    stamp: Stamp | None
    arrived: float
    source: str

    def age_s(self, now: float) -> float:
        """Return its age in seconds."""
        return now - self.arrived


class Call(Protocol):
    """A command that waits for its answer; also a `put`, which is not `answerable`.

    `arrived`: when it was sent, otherwise when it arrived, on our clock. `remote`: it comes from another machine, which
    sent it at `sender_s` by its own monotonic clock (NaN: unknown). `waited_s`: how long it had waited at its sender.
    `by`: the original sender, for whom its sender acts; empty without one, and from another machine, where it would
    prove nothing.
    """

    name: str
    message: Any
    source: str
    arrived: float
    remote: bool
    sender_s: float
    waited_s: float
    by: str
    answerable: bool

    def reply(self, answer: Struct, *, quiet: bool = False) -> None:
        """Answer, once. A refusal is also an event, unless it is `quiet` and the sender waits for the answer."""

    def refuse(self, reason: str | Reason, code: Code = "refused") -> None:
        """Answer `{"accepted": false, "reason": …, "code": …}`; a `Reason` has its own code."""


class EmergencyStop(Protocol):
    """The latch as this process knows it, from its own session; `by` was the last to press or reset it.

    After a release, a capability sets `follows`: whether it would accept the next command.
    """

    engaged: bool
    reason: str
    by: str
    follows: bool

    def acknowledge(self, *, stopped: bool, reason: str = "") -> None:
        """Report whether the device has acknowledged the stop; cheap to repeat, published on change."""

    def serve(self) -> None:
        """Answer releases; only for the runtime."""

    def close(self) -> None:
        """Leave the bus; only for the runtime."""


@dataclass(frozen=True, slots=True)
class Device:
    """A device row: its address, and the settings of its type. Its line copies its bytes to `tap`."""

    name: str
    type: str
    address: str
    settings: JsonObject
    tap: Tap = field(default_factory=Tap, compare=False, repr=False)


class Context(Protocol[S_co]):
    """Everything that a capability may do; implemented by the process that runs it.

    `on_tick`: this step belongs to the fixed rate, and is not a wake-up in between. `simulated`: all devices are
    emulated. A capability sets `live_lease`: commands that quote it are served before all others.
    """

    robot: str
    name: str
    simulated: bool
    device: Device | None
    devices: tuple[Device, ...]
    home: str
    on_tick: bool
    live_lease: str

    @property
    def settings(self) -> S_co:
        """The row's settings, checked."""

    @property
    def estop(self) -> EmergencyStop:
        """The emergency stop as this process knows it."""

    def rows(self, row: type[R]) -> tuple[R, ...]:
        """Return the rows of a table that the kind reads, in the order of their keys."""

    def clock(self) -> float:
        """Monotonic seconds."""

    def publish(self, output: str, message: Struct, *, taken_s: float | None = None) -> None:
        """Publish on an output; the message also answers a later `get`. Never blocks, never raises without a bus.

        `taken_s` is when a picture was taken, by the monotonic clock; it becomes the time of the stamp. A message of
        another type than the kind declares raises TypeError.
        """

    def forget(self, output: str) -> None:
        """Stop answering `get` with the last message of an output, until there is a new one."""

    def watched(self, output: str) -> bool:
        """Return whether there is a subscriber of an output of pictures; `step` is called when that changes.

        For other outputs that is unknown, and they count as watched.
        """

    def wake(self) -> None:
        """Have `step` called at once; may be called from any thread, such as one that waits for a device."""

    def latest(self, port: str) -> Received | None:
        """Return the newest message of an input or setpoint, or None before the first.

        Pictures are received while they are read, by this or by `take`. The first call may wait 0.1 s for one; two
        seconds after the last call, the camera may rest.
        """

    def take(self, port: str) -> list[Received]:
        """Return the messages of an input or setpoint since the last call, oldest first; its channel limits them."""

    def sources(self, port: str) -> tuple[str, ...]:
        """Return the names of the capabilities wired to an input or setpoint."""

    def alive(self, capability: str) -> bool:
        """Return whether another capability is present; the death of its process is known within milliseconds."""

    def targets(self, request: str) -> tuple[str, ...]:
        """Return the names of the capabilities wired to a request."""

    def ask(
        self, request: str, message: Struct, timeout_s: float, *, only: Collection[str] | None = None
    ) -> PendingReply:
        """Ask every capability wired to a request, or `only` some of them; poll the result in later steps.

        The loop wakes on answers. A request during a command carries the name and the date of that command's sender.
        """

    def event(
        self,
        kind: str,
        text: str,
        *,
        level: str = "info",
        data: JsonObject | None = None,
        code: str = "",
        about: str = "",
    ) -> None:
        """Publish on `@event`; the executive stores it. `code` is of the reason, `about` names the command's sender."""

    def engage_estop(self, reason: str) -> None:
        """Latch the emergency stop of everything that moves; movers receive it directly, not through the executive."""

    def learn(self, *rows: Row) -> None:
        """Have learnt rows stored; `rows` has them at once, and the capability is not restarted for them."""

    def adopt(self, rows: Iterable[Row]) -> None:
        """Use the rows of an accepted edit, for which the executive does not restart this capability."""

    def ready(self, reason: str = "") -> None:
        """Report that this capability works; the runtime does so after the first `step`, unless that has warned."""

    def warn(self, reason: str | Reason, code: Code = "failed") -> None:
        """Report that it works only partly: degraded, with the reason and its code; a `Reason` has its own."""
