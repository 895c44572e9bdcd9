"""The robot as a running capability sees it: settings, wiring, bus and emergency stop."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

from msgspec import Struct

from lbr.capability.tap import Tap
from lbr.leases.client import PendingReply
from lbr.messages.codes import Code, Reason
from lbr.messages.rows import Row
from lbr.messages.system import Stamp

R = TypeVar("R", bound=Row)
S_co = TypeVar("S_co", bound=Struct, covariant=True)


class Received(Struct, frozen=True):
    """A message with its stamp (None: the sender gave none), and when it was sent, or else came, on our clock."""

    message: Any
    stamp: Stamp | None
    arrived: float
    source: str

    def age_s(self, now: float) -> float:
        """Seconds since then."""
        return now - self.arrived


class Call(Protocol):
    """A command waiting for its answer; a `put` is one too, that is not `answerable`.

    `arrived`: when it was sent, or else came, on our clock. `remote`: from another machine, where it was sent at
    `sender_s` by that machine's monotonic clock (NaN: unknown). `waited_s`: for this long it had waited at its sender.
    `by`: who asked its sender for it; empty where nobody did, and from another machine, where it would prove nothing.
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
        """Answer, once. A refusal is an event too, unless it is `quiet` and the sender waits for the answer."""

    def refuse(self, reason: str | Reason, code: Code = "refused") -> None:
        """Answer `{"accepted": false, "reason": …, "code": …}`; a `Reason` brings its own code."""


class EmergencyStop(Protocol):
    """The latch as this process knows it, straight from its own session; `by` pressed it last, or reset it.

    A capability sets `follows` after a release: whether its next command would be obeyed.
    """

    engaged: bool
    reason: str
    by: str
    follows: bool

    def acknowledge(self, *, stopped: bool, reason: str = "") -> None:
        """Say whether the device has acknowledged the stop; cheap to repeat, published on change."""

    def serve(self) -> None:
        """Answer releases; the runtime's business."""

    def close(self) -> None:
        """Leave the bus; the runtime's business."""


@dataclass(frozen=True, slots=True)
class Device:
    """A device row: where it is (`address`) and what its type may set. Its line gives its bytes to `tap`."""

    name: str
    type: str
    address: str
    settings: dict[str, Any]
    tap: Tap = field(default_factory=Tap, compare=False, repr=False)


class Context(Protocol[S_co]):
    """Everything a capability may do; implemented by the process that runs it.

    `on_tick` says that this step is one of the fixed rate, not a wake-up in between. `simulated`: no device is real.
    A capability sets `live_lease`: commands that quote it are served before all others.
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
        """Publish on an output; it is also the answer to a later `get`. Never blocks, never raises on a dead bus.

        `taken_s` is when a picture was taken, by the monotonic clock: its stamp bears that time.
        TypeError: the message is of another type than the kind declares.
        """

    def forget(self, output: str) -> None:
        """Answer no `get` any more with what was published there, until there is something new."""

    def watched(self, output: str) -> bool:
        """Return whether there is a subscriber of an output of pictures; `step` is called when that changes.

        Of other outputs that is not known, and they count as watched.
        """

    def wake(self) -> None:
        """Have `step` called at once; from any thread, such as one that waits for a device."""

    def latest(self, port: str) -> Received | None:
        """Return the newest message of an input or setpoint, or None before the first.

        Pictures are received for as long as they are read, by this or by `take`: the first call may wait 0.1 s for one,
        and two seconds after the last one the camera may rest.
        """

    def take(self, port: str) -> list[Received]:
        """Return what arrived on an input or setpoint since the last call, oldest first, as deep as its channel."""

    def sources(self, port: str) -> tuple[str, ...]:
        """Return the names of the capabilities wired to an input or setpoint."""

    def alive(self, capability: str) -> bool:
        """Return whether another capability's process is on the bus; its death is known within milliseconds."""

    def targets(self, request: str) -> tuple[str, ...]:
        """Return the names of the capabilities wired to a request."""

    def ask(
        self, request: str, message: Struct, timeout_s: float, *, only: Collection[str] | None = None
    ) -> PendingReply:
        """Ask every capability wired to a request, or `only` some of them; poll the result in later steps.

        The loop wakes on answers. A request during a command bears the name and the date of that command's sender.
        """

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
        """Publish on `@event`; the executive writes it down. `code` says why, `about` whose command or motion it
        concerns."""

    def engage_estop(self, reason: str) -> None:
        """Latch the emergency stop of everything that moves; each mover hears it directly, not through the
        executive."""

    def learn(self, *rows: Row) -> None:
        """Have rows that the kind learns written down; `rows` has them at once, and it goes on without a restart."""

    def adopt(self, rows: Iterable[Row]) -> None:
        """Go on with the rows of an edit that was accepted, as far as the kind reads them: `rows` has them at once.

        The executive counts on it, and does not restart this capability for them.
        """

    def ready(self, reason: str = "") -> None:
        """Say that this capability works; the runtime does so after the first `step`, unless that has warned."""

    def warn(self, reason: str | Reason, code: Code = "failed") -> None:
        """Say that it works, but not as it should: degraded, with the reason and its code; a `Reason` brings its
        own."""
