"""New device rows of a simulated robot: the world is asked to emulate them while it runs, and restarted only if it cannot."""

from collections.abc import Callable
from typing import NamedTuple

from msgspec import Struct

from lbr.bus import keys, wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.capability.config import DeviceConfig
from lbr.errors import BusError, MalformedError
from lbr.messages.leases import CommandReply

WITHIN_S = 1.0
"""A world answers within milliseconds; one that does not is better begun again than waited for."""
COMMAND = "plug"
_replies = Decoder(CommandReply)


class PlugDevice(Struct, frozen=True, kw_only=True):
    """What a world is asked for."""

    device: str
    type: str
    address: str
    settings: dict[str, object]


class _Asked(NamedTuple):
    world: str
    process: object
    device: str
    question: wire.PendingQuery


class Plugging:
    """Asks worlds, and looks what became of it. `process(name)` is what runs of a capability, `restart(name, why)` begins it again."""

    def __init__(
        self,
        bus: Session,
        robot: str,
        *,
        process: Callable[[str], object],
        restart: Callable[[str, str], None],
        wake: Callable[[], None],
    ) -> None:
        self._bus = bus
        self._robot = robot
        self._process = process
        self._restart = restart
        self._wake = wake
        self._asked: list[_Asked] = []

    def ask(self, world: str, devices: tuple[DeviceConfig, ...]) -> None:
        """Ask a world that runs to emulate more devices."""
        process = self._process(world)
        for one in devices if process is not None else ():
            wanted = PlugDevice(device=one.name, type=one.type, address=one.address, settings=one.settings)
            key = keys.port(self._robot, world, COMMAND)
            try:
                question = wire.PendingQuery(
                    self._bus, key, wire.encode(wanted), timeout_s=WITHIN_S, source="executive", wake=self._wake
                )
            except BusError as err:
                self._restart(world, str(err))
                return
            self._asked.append(_Asked(world, process, one.name, question))

    def step(self) -> None:
        """Begin a world again that could not do as asked, once; one that has begun again meanwhile has its devices."""
        done = [one for one in self._asked if one.question.done]
        self._asked = [one for one in self._asked if not one.question.done]
        begun = set()
        for one in done:
            why = _why_not(one.question)
            if why and one.world not in begun and self._process(one.world) is one.process:
                begun.add(one.world)
                self._restart(one.world, f"device '{one.device}' cannot be plugged in while it runs: {why}")


def _why_not(question: wire.PendingQuery) -> str:
    if not question.replies:
        return "it does not answer"
    try:
        reply = _replies.decode(question.replies[0].payload)
    except MalformedError as err:
        return str(err)
    return "" if reply.accepted else reply.reason
