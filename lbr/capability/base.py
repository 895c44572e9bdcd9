"""The life of a capability: open, step, close. Subclass it, and the runtime does the rest."""

from typing import Generic, TypeVar

from msgspec import Struct

from lbr.capability.context import Call, Context, Device
from lbr.errors import DeviceError
from lbr.messages.codes import Reason

S = TypeVar("S", bound=Struct)


class Capability(Generic[S]):
    """A driver, operation or app, running in a process of its own with everything it needs in `self.ctx`.

    The runtime calls `open` once, then `step` at `rate_hz` and whenever something arrived; every call on one thread.
    A capability may change its `rate_hz` as it goes: what has nothing to do needs no fast one, and commands wake it.
    With `woken_by_streams` false what inputs and setpoints bring waits for the next tick, which spares a process that
    reads fast streams most of its work; commands, answers and the emergency stop wake it all the same.
    Inputs in `received_while_read` are received like pictures: while they are read, and two seconds longer.
    A DeviceError out of `open` or `step` makes the capability degraded: the runtime calls `close` and opens again
    with a capped backoff. Any other exception ends the process, and the executive decides what follows.
    """

    rate_hz: float = 10.0
    woken_by_streams: bool = True
    received_while_read: frozenset[str] = frozenset()

    def __init__(self, ctx: Context[S]) -> None:
        self.ctx = ctx

    @property
    def device_row(self) -> Device:
        """Return the device row that the settings name; raise a DeviceError that names a missing one."""
        if self.ctx.device is None:
            name = getattr(self.ctx.settings, "device", "")
            raise DeviceError(f"'{self.ctx.name}' has no device row '{name}'; add it")
        return self.ctx.device

    def open(self) -> None:
        """Acquire what the row names; must return within a second or raise DeviceError."""

    def step(self) -> None:
        """Do one round of work; must not block longer than a few milliseconds."""

    def answers(self) -> bool:
        """Return whether its device has said anything since it was opened; it is not called ready before."""
        return True

    def lacks(self) -> Reason | None:
        """Return why its first command would be refused, or nothing; it is called degraded until then, and ready
        after."""
        return None

    def awaited(self, *inputs: str) -> Reason | None:
        """Return that nothing has come yet on one of these inputs, of those that are wired; for `lacks`."""
        wired = {port: self.ctx.sources(port) for port in inputs if self.ctx.latest(port) is None}
        sources = dict.fromkeys(source for port in wired for source in wired[port])
        return Reason("not_ready", f"nothing has come from {', '.join(sources)} yet") if sources else None

    def command(self, call: Call) -> None:
        """Answer a command with `call.reply`, now or in a later step."""
        call.refuse(f"{call.name} is not understood here", "unknown_command")

    def degraded(self, reason: str) -> None:
        """Tell the others that the device is away; called when it goes and every half second until it is back."""

    def woke(self, slept_s: float) -> None:
        """Called before the next step once the computer was suspended, while no deadline passed: end what moves."""

    def close(self) -> None:
        """Stop motion first, then close everything; called on every way out that allows it."""
