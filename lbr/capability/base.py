"""The life of a capability: open, step, close. A subclass fills these in, and the runtime does the rest."""

from typing import Generic

from lbr.capability.context import Call, Context, Device, S_co
from lbr.errors import DeviceError
from lbr.messages.codes import Reason


class Capability(Generic[S_co]):
    """A driver, operation or app, running in a process of its own with everything it needs in `self.ctx`.

    The runtime calls `open` once, then `step` at `rate_hz` and whenever something arrived; every call on one thread. It
    may change its `rate_hz` at any time: an idle capability needs no fast one, as commands wake it. Without
    `woken_by_streams`, inputs and setpoints wait for the next tick, which saves a reader of fast streams most of its
    work. It may also name the ports that wake it. Commands, answers and the emergency stop always do. Inputs in
    `received_while_read` are received like pictures: while they are read, and two seconds longer. A DeviceError out of
    `open` or `step` makes it degraded: the runtime calls `close`, and opens again with a capped backoff. Any other
    exception ends the process, and the executive decides whether to restart it.
    """

    rate_hz: float = 10.0
    woken_by_streams: bool | frozenset[str] = True
    received_while_read: frozenset[str] = frozenset()

    def __init__(self, ctx: Context[S_co]) -> None:
        self.ctx = ctx

    @property
    def device_row(self) -> Device:
        """Return the device row of the settings; raise a DeviceError that names a missing one."""
        if self.ctx.device is None:
            name = getattr(self.ctx.settings, "device", "")
            raise DeviceError(f"'{self.ctx.name}' has no device row '{name}'; add it")
        return self.ctx.device

    def open(self) -> None:
        """Acquire the device or resources of the row; must return within a second or raise DeviceError."""

    def step(self) -> None:
        """Do one round of work; must not block longer than a few milliseconds."""

    def answers(self) -> bool:
        """Return whether its device has answered since it was opened; until then it is not ready."""
        return True

    def lacks(self) -> Reason | None:
        """Return why it would refuse its first command, or None; it is degraded until then, and ready after."""
        return None

    def awaited(self, *inputs: str) -> Reason | None:
        """Return that one of these inputs is wired and has received nothing yet; for `lacks`."""
        wired = {port: self.ctx.sources(port) for port in inputs if self.ctx.latest(port) is None}
        sources = dict.fromkeys(source for port in wired for source in wired[port])
        return Reason("not_ready", f"nothing has come from {', '.join(sources)} yet") if sources else None

    def command(self, call: Call) -> None:
        """Answer a command with `call.reply`, now or in a later step."""
        call.refuse(f"{call.name} is not understood here", "unknown_command")

    def degraded(self, reason: str) -> None:
        """Report that the device is missing; called when it goes and every half second until it is back."""

    def woke(self, slept_s: float) -> None:
        """Stop what moves: called before the next step if the computer was suspended, as deadlines stood still."""

    def close(self) -> None:
        """Stop motion first, then close everything; called on every exit that permits it."""
