"""The process around the drive kernel: feeds it what arrives and the time, and publishes what it says."""

import secrets
from collections import deque
from dataclasses import dataclass
from math import inf
from typing import Any

from lbr.capability.base import Capability
from lbr.capability.context import Asked, Call, Context
from lbr.messages.drive import CheckVerdict, DriveState, LoopStatistics
from lbr.messages.motors import MotorSetpoint
from lbr.operations.drive.acceptance import to_be_checked
from lbr.operations.drive.asked import Motion, shown
from lbr.operations.drive.kernel import decide, drive_state, first_state
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import (
    AttitudeSeen,
    Command,
    Event,
    MotorsLost,
    MotorsSeen,
    OdometrySeen,
    RangesSeen,
    Tick,
)
from lbr.operations.leasing.lease import EstopChanged, Happened, Reply, Result, Setpoint, Stop
from lbr.operations.statistics import Beat, LoopMeter

STATE_PERIOD_S = 0.1
MOST_WAITING = 16
MOTIONS = frozenset({"command", "turn", "heading"})
UNANSWERED = {"(none in time)": None}


@dataclass(frozen=True, slots=True)
class Waiting:
    """A command that waits for the user's checks."""

    call: Call
    asked: Asked
    until: float


class Drive(Capability[DriveSettings]):
    """Drive operations: every decision is the kernel's, every message passes here."""

    _loop: LoopStatistics | None

    def __init__(self, ctx: Context[DriveSettings]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.rate_hz
        self._begin()

    def open(self) -> None:
        """Begin with nobody holding the base, and at once with zero."""
        self._begin()
        self._listen()
        self._decide(Tick())

    def step(self) -> None:
        """Take in what arrived; at the loop's rate publish the setpoint."""
        self._listen()
        self._settle()
        now = self.ctx.clock()
        if self._beat.due(now):
            self._loop = self._meter.round(now) or self._loop
            self._decide(Tick())
        self._report()

    def command(self, call: Call) -> None:
        """Decide a command or stop now, or once the user's checks have answered."""
        self._listen()
        if call.name == "stop":
            said = call.message
            self._decide(Stop(source=call.source, received=call.arrived, reason=said.reason, whole=said.whole), call)
        elif call.name in MOTIONS:
            self._command(call)
        else:
            call.refuse(f"{call.name} is not understood here", "unknown_command")
        self._report()

    def close(self) -> None:
        """Publish zero; end what was going on."""
        self.ctx.publish("setpoint", MotorSetpoint(left=0.0, right=0.0))
        while self._waiting:
            self._waiting.popleft().call.refuse("drive operations end", "shutting_down")
        now = self.ctx.clock()
        self._decide(Stop(source=self.ctx.name, received=now, reason="drive operations end"))
        self._report()

    def _begin(self) -> None:
        self._state = first_state(self.ctx.settings, self.ctx.clock())
        self._beat = Beat(self.rate_hz)
        self._meter = LoopMeter(self.rate_hz)
        self._loop = None
        self._waiting: deque[Waiting] = deque()
        self._motors_at = -inf
        self._motors_alive = False
        self._alive_holder = ""
        self._reported: DriveState | None = None
        self._reported_at = -inf

    def _listen(self) -> None:
        estop = self.ctx.estop
        if estop.engaged != self._state.holding.estop:
            self._decide(EstopChanged(engaged=estop.engaged, reason=estop.reason))
        if estop.engaged and self._at_rest():
            estop.acknowledge(stopped=True)
        self._listen_to_motors()
        self._watch_holder()
        for received in self.ctx.take("ranges"):
            self._decide(RangesSeen(ranges=received.message, arrived=received.arrived))
        for received in self.ctx.take("attitude"):
            self._decide(AttitudeSeen(attitude=received.message, arrived=received.arrived))
        for received in self.ctx.take("odometry"):
            self._decide(OdometrySeen(odometry=received.message, arrived=received.arrived))

    def _listen_to_motors(self) -> None:
        sources = self.ctx.sources("motors")
        alive = any(self.ctx.alive(source) for source in sources)
        if self._motors_alive and not alive:
            self._decide(MotorsLost(reason=f"the motor driver ({', '.join(sources)}) is gone"))
        self._motors_alive = alive
        newest = self.ctx.latest("motors")
        if newest is not None and newest.arrived > self._motors_at:
            self._motors_at = newest.arrived
            self._decide(MotorsSeen(motors=newest.message, arrived=newest.arrived))

    def _watch_holder(self) -> None:
        """End the motion of a capability whose process is gone; of others only the lease tells."""
        holder = self._state.hold.source if self._state.hold is not None else ""
        alive = bool(holder) and self.ctx.alive(holder)
        if holder and holder == self._alive_holder and not alive:
            self._decide(Stop(source=holder, received=self.ctx.clock(), reason="its process is gone"))
        self._alive_holder = holder if alive else ""

    def _command(self, call: Call) -> None:
        event = _event(call)
        if not to_be_checked(self._state, event, self.ctx.clock()):
            self._decide(event, call)
        elif len(self._waiting) >= MOST_WAITING:
            call.refuse("too many commands wait for checks; send fewer", "busy")
        else:
            self._ask(call, event.command)
            self._settle()

    def _ask(self, call: Call, command: Motion) -> None:
        timeout_s = self.ctx.settings.checks_timeout_s
        question = shown(call.source, command, self.ctx.settings)
        asked = self.ctx.ask("checks", question, timeout_s=timeout_s)
        self._waiting.append(Waiting(call, asked, self.ctx.clock() + 2 * timeout_s))

    def _settle(self) -> None:
        """Decide the commands whose checks have answered, in the order they came."""
        while self._waiting:
            waiting = self._waiting[0]
            answers = waiting.asked.answers()
            if answers is None and self.ctx.clock() < waiting.until:
                return
            self._waiting.popleft()
            self._decide(_event(waiting.call, UNANSWERED if answers is None else dict(answers)), waiting.call)

    def _decide(self, event: Event, call: Call | None = None) -> None:
        self._state, outputs = decide(self._state, event, self.ctx.clock())
        for output in outputs:
            match output:
                case Setpoint(message=setpoint):
                    self.ctx.publish("setpoint", setpoint)
                case Result(message=result):
                    self.ctx.publish("result", result)
                case Happened():
                    self.ctx.event(
                        output.kind,
                        output.text,
                        level=output.level,
                        data=dict(output.data),
                        code=output.code,
                        about=output.about,
                    )
                case Reply(message=reply, late=late):
                    if call is not None:
                        call.reply(reply, quiet=late)

    def _report(self) -> None:
        now = self.ctx.clock()
        state = drive_state(self._state, now, self._loop)
        due = now - self._reported_at >= STATE_PERIOD_S
        if due or self._reported is None or _gist(state) != _gist(self._reported):
            self._reported, self._reported_at = state, now
            self.ctx.publish("state", state)

    def _at_rest(self) -> bool:
        return self._state.holding.estop and self._state.left == 0.0 and self._state.right == 0.0


def _event(call: Call, answers: dict[str, Any] | None = None) -> Command:
    verdicts = {name: said if isinstance(said, CheckVerdict) else None for name, said in (answers or {}).items()}
    return Command(
        command=call.message,
        source=call.source,
        new_lease=secrets.token_hex(8),
        new_goal=f"goal-{secrets.token_hex(4)}",
        received=call.arrived,
        remote=call.remote,
        sender_s=call.sender_s,
        waited_s=call.waited_s,
        answerable=call.answerable,
        checks=verdicts,
    )


def _gist(state: DriveState) -> tuple[object, ...]:
    """What is worth telling at once when it changes."""
    stopped_by = "" if state.moving else state.reason
    asked = (state.power, state.angle_deg)
    told = bool(state.limited_by), stopped_by, state.stopped_s, state.estop
    return (state.moving, asked, state.holder, state.goal, *told)
