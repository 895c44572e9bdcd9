"""Edits that reach a running process: new devices of a simulated robot, and rows that a kind follows. The process
receives them by a command, and is restarted only if that fails."""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field
from math import inf
from typing import NamedTuple

from msgspec import Struct

from lbr.bus import keys, wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.capability.config import DeviceConfig
from lbr.errors import BusError, MalformedError
from lbr.executive.services import Service
from lbr.messages.leases import CommandReply
from lbr.messages.rows import RowsChanged

WITHIN_S = 5.0
"""A process answers within milliseconds, or later on a busy machine; one that hangs is ended before."""
_replies = Decoder(CommandReply)


class PlugDevice(Struct, frozen=True, kw_only=True):
    """The request to a world to emulate a device."""

    device: str
    type: str
    address: str
    settings: dict[str, object]


class _Asked(NamedTuple):
    name: str
    process: object
    failure: str
    question: wire.PendingQuery


@dataclass(eq=False)
class Plugging(Service):
    """Sends edits to processes, and checks the replies; `process(name)` is one, `restart(name, why)` restarts it."""

    bus: Session
    robot: str
    _: KW_ONLY
    process: Callable[[str], object]
    restart: Callable[[str, str], None]
    wake: Callable[[], None]
    _asked: list[_Asked] = field(default_factory=list, init=False)

    def ask(self, world: str, devices: tuple[DeviceConfig, ...]) -> None:
        """Ask a running world to emulate more devices."""
        for one in devices:
            wanted = PlugDevice(device=one.name, type=one.type, address=one.address, settings=one.settings)
            key = keys.port(self.robot, world, "plug")
            if not self._ask(world, key, wanted, f"device '{one.name}' cannot be plugged in while it runs"):
                return

    def tell(self, name: str, rows: RowsChanged) -> None:
        """Send the edited rows to a running capability."""
        failure = f"it cannot go on with other rows of {', '.join(rows.rows)}"
        self._ask(name, keys.edit(self.robot, name), rows, failure)

    def step(self, _now: float) -> float:
        """Restart a process whose request failed, once; a process that has restarted meanwhile has the edit already."""
        done = [asked for asked in self._asked if asked.question.done]
        self._asked = [asked for asked in self._asked if not asked.question.done]
        begun = set()
        for asked in done:
            why = _why_not(asked.question)
            if why and asked.name not in begun and self.process(asked.name) is asked.process:
                begun.add(asked.name)
                self.restart(asked.name, f"{asked.failure}: {why}")
        return inf

    def _ask(self, name: str, key: str, message: Struct, failure: str) -> bool:
        """Send a request to a process, if it runs; return whether it was sent."""
        process = self.process(name)
        if process is None:
            return False
        try:
            question = wire.PendingQuery(
                self.bus, key, wire.encode(message), timeout_s=WITHIN_S, source="executive", wake=self.wake
            )
        except BusError as err:
            self.restart(name, str(err))
            return False
        self._asked.append(_Asked(name, process, failure, question))
        return True


def _why_not(question: wire.PendingQuery) -> str:
    if not question.replies:
        return "it does not answer"
    try:
        reply = _replies.decode(question.replies[0].payload)
    except MalformedError as err:
        return str(err)
    return "" if reply.accepted else reply.reason
