"""One camera on at a time: the others are switched off first, and the reply names the failures."""

from collections import deque
from dataclasses import dataclass

from lbr.apps.cameras.kind import OFF, CamerasSettings
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.leases.client import PendingReply
from lbr.messages.camera import CameraPhase, CamerasState, CameraState, SelectCommand, SwitchCommand
from lbr.messages.leases import CommandReply

PREFIX = "camera_"
OFF_S, ON_S = 0.7, 1.2
"""The time for a camera's answer to a switch; a camera answers a little sooner."""
STATE_PERIOD_S = 0.95
"""A little less than a second, so that the second round at 2 Hz publishes."""
MOST_WAITING = 8
FIRST_S = 1.0
"""The wait of the first state for the states of all cameras."""


@dataclass(slots=True)
class _Selecting:
    """A selection under way: first the others are switched off, then the wanted one on."""

    call: Call
    wanted: str
    others: list[str]
    asked: PendingReply
    failures: list[str]


class Cameras(Capability[CamerasSettings]):
    """Selects one of the cameras wired to its request `switch`, by their names without `camera_`."""

    rate_hz = 2.0

    def __init__(self, ctx: Context[CamerasSettings]) -> None:
        super().__init__(ctx)
        self._names = {capability.removeprefix(PREFIX): capability for capability in ctx.targets("switch")}
        self._states: dict[str, CameraState] = {}
        self._waiting: deque[Call] = deque()
        self._selecting: _Selecting | None = None
        self._published: dict[str, tuple[bool, CameraPhase, str]] | None = None
        self._publish_at = 0.0
        self._first_at = ctx.clock() + FIRST_S

    def step(self) -> None:
        """Advance the selection, and publish which camera is on."""
        for received in self.ctx.take("states"):
            self._states[received.source] = received.message
        self._go_on()
        self._publish_state()

    def command(self, call: Call) -> None:
        """Queue a selection; its reply follows those of the cameras."""
        message = call.message
        if not isinstance(message, SelectCommand):
            call.refuse(f"{call.name} is not understood here", "unknown_command")
        elif message.name not in {*self._names, OFF}:
            call.refuse(
                f"there is no camera '{message.name}'; there are {', '.join([*self._names, OFF])}", "unknown_name"
            )
        elif len(self._waiting) >= MOST_WAITING:
            call.refuse("the cameras are still being switched", "busy")
        else:
            self._waiting.append(call)
            self._go_on()

    def _go_on(self) -> None:
        """Send the next switch once the last one is answered; begin the next selection."""
        while True:
            now = self._selecting
            if now is None:
                if not self._waiting:
                    return
                self._selecting = self._begun(self._waiting.popleft())
                continue
            answers = now.asked.answers()
            if answers is None:
                return
            now.failures += [_failure(name, reply) for name, reply in answers.items() if not _done(reply)]
            if now.wanted and now.others:
                now.others = []
                now.asked = self._ask([now.wanted], on=True)
                continue
            self._selecting = None
            now.call.reply(_reply(now))

    def _begun(self, call: Call) -> _Selecting:
        wanted = self._names.get(call.message.name, "")
        others = [capability for capability in self._names.values() if capability != wanted]
        asked = self._ask(others, on=False) if others else self._ask([wanted], on=True)
        return _Selecting(call, wanted, others, asked, [])

    def _ask(self, names: list[str], *, on: bool) -> PendingReply:
        return self.ctx.ask("switch", SwitchCommand(on=on), ON_S if on else OFF_S, only=names)

    def _publish_state(self) -> None:
        known = {short: self._states[name] for short, name in self._names.items() if name in self._states}
        seen = {short: state for short, state in known.items() if self.ctx.alive(self._names[short])}
        on = [short for short, state in seen.items() if state.on]
        now = self.ctx.clock()
        if self._published is None and len(seen) < len(self._names) and now < self._first_at:
            return
        essence = {short: (state.on, state.phase, state.reason) for short, state in seen.items()}
        if now >= self._publish_at or essence != self._published:
            self._published, self._publish_at = essence, now + STATE_PERIOD_S
            self.ctx.publish("state", CamerasState(selected=", ".join(on) or OFF, cameras=seen))


def _done(reply: CommandReply | None) -> bool:
    return reply is not None and reply.accepted


def _failure(name: str, reply: CommandReply | None) -> str:
    short = name.removeprefix(PREFIX)
    return f"{short}: {reply.reason if reply is not None else 'no answer'}"


def _reply(done: _Selecting) -> CommandReply:
    chosen = f"{done.wanted.removeprefix(PREFIX)} is on" if done.wanted else "all cameras are off"
    if done.failures:
        return CommandReply(accepted=False, reason="; ".join(done.failures), code="failed")
    return CommandReply(accepted=True, reason=chosen)
