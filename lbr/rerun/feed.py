"""Says the recorded commands to a robot that runs again, at the times of then, and keeps its answers."""

import contextlib
import threading
from collections import deque
from collections.abc import Iterable, Mapping
from typing import Any

import msgspec
from msgspec import Struct

from lbr.bus import keys, wire
from lbr.bus.session import Session
from lbr.errors import BusError
from lbr.messages.system import EstopRequest
from lbr.recording.lines import Command

ANSWER_S = 3.0
WAIT_S = 0.02


class Said(Struct):
    """A command that was said again: when, by the recording's clock, and what was answered; None: nothing yet."""

    command: Command
    at_ns: int
    reply: Mapping[str, Any] | None = None

    @property
    def alike(self) -> bool:
        """Say whether it was answered as in the recording, whatever leases are called."""
        if not self.command.answerable:
            return True
        return self.reply is not None and _judged(self.reply) == _judged(self.command.reply)


class Feed:
    """The commands from outside, oldest first; a lease of then is the one that was given for it now."""

    def __init__(
        self, bus: Session, robot: str, commands: Iterable[Command], stops: Iterable[tuple[int, bool]]
    ) -> None:
        self.said: list[Said] = []
        self.begun_before = 0
        self.late_ns = 0
        self._bus, self._robot = bus, robot
        self._commands = deque(commands)
        self._stops = deque(stops)
        self._woken = threading.Event()
        self._leases: dict[str, str] = {}
        self._waiting: list[tuple[Said, wire.PendingQuery]] = []

    def step(self, now_ns: int) -> None:
        """Say what is due, and read answers."""
        self._hear()
        while self._stops and self._stops[0][0] <= now_ns:
            self._emergency(engaged=self._stops.popleft()[1])
        while self._commands and self._commands[0].at_ns <= now_ns:
            command = self._commands.popleft()
            self.late_ns = max(self.late_ns, now_ns - command.at_ns)
            self._say(command, now_ns)

    @property
    def next_ns(self) -> int | None:
        """When the next command was said."""
        return min((one for one in (self._next_command, self._next_stop) if one is not None), default=None)

    @property
    def waits(self) -> bool:
        """Say whether answers are still to come."""
        self._hear()
        return bool(self._waiting)

    @property
    def _next_command(self) -> int | None:
        return self._commands[0].at_ns if self._commands else None

    @property
    def _next_stop(self) -> int | None:
        return self._stops[0][0] if self._stops else None

    def _say(self, command: Command, now_ns: int) -> None:
        message = command.message
        if lease := str(message.get("lease", "")):
            self._await(lease)
            if lease not in self._leases:
                self.begun_before += 1
                return
            message = message | {"lease": self._leases[lease]}
        key = keys.port(self._robot, command.to, command.name)
        said = Said(command, now_ns)
        self.said.append(said)
        payload = msgspec.json.encode(message)
        if command.answerable:
            query = wire.PendingQuery(
                self._bus, key, payload, timeout_s=ANSWER_S, source=command.source, wake=self._woken.set
            )
            self._waiting.append((said, query))
        else:
            wire.put(self._bus, key, msgspec.Raw(payload), source=command.source, urgent=True)

    def _await(self, lease: str) -> None:
        """Have the answer by which a lease was given, if it is under way: what follows quotes it."""
        for said, query in list(self._waiting):
            if said.command.reply.get("lease") == lease:
                while not query.replies and not query.done:
                    self._woken.clear()
                    self._woken.wait(WAIT_S)
        self._hear()

    def _hear(self) -> None:
        waiting = []
        for said, query in self._waiting:
            if query.replies:
                with contextlib.suppress(msgspec.DecodeError, UnicodeDecodeError):
                    said.reply = msgspec.json.decode(query.replies[0].payload)
                if (given := said.command.reply.get("lease")) and said.reply and said.reply.get("lease"):
                    self._leases[str(given)] = str(said.reply["lease"])
            elif not query.done:
                waiting.append((said, query))
        self._waiting = waiting

    def _emergency(self, *, engaged: bool) -> None:
        with contextlib.suppress(BusError):
            if engaged:
                request = EstopRequest(engaged=True, reason="as recorded")
                wire.put(self._bus, keys.estop(self._robot), request, source="lbr replay", urgent=True)
            else:
                key = keys.estop_reset(self._robot)
                wire.PendingQuery(self._bus, key, b"{}", timeout_s=ANSWER_S, source="lbr replay")


def _judged(reply: Mapping[str, Any]) -> tuple[Any, Any, Any]:
    return reply.get("accepted"), reply.get("code", ""), reply.get("cause", "")
