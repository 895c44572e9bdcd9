"""The process around the joints kernel: feeds it what arrives and the time, and publishes what it says."""

import secrets
from collections import deque
from dataclasses import dataclass
from math import inf

from msgspec.structs import replace

from lbr.capability.base import Capability
from lbr.capability.context import Asked, Call, Context
from lbr.messages.drive import LoopStatistics
from lbr.messages.joints import Joint, JointsCommand, JointsState, RecoverCommand
from lbr.messages.leases import CommandReply
from lbr.messages.servos import RecoverServos
from lbr.operations.joints import asked
from lbr.operations.joints.body import body
from lbr.operations.joints.kernel import decide
from lbr.operations.joints.moving import setpoint
from lbr.operations.joints.settings import JointsSettings
from lbr.operations.joints.state import (
    Command,
    Event,
    HolderGone,
    ServosLost,
    ServosSeen,
    State,
    Tick,
    Torque,
    first_state,
)
from lbr.operations.joints.view import joints_state
from lbr.operations.leasing.lease import EstopChanged, Happened, Reply, Result, Setpoint, Stop
from lbr.operations.statistics import Beat, LoopMeter

STATE_PERIOD_S = 0.1
MOVING_PERIOD_S = 0.045
"""While joints move, their state is told more than 20 times a second, also of servos that are read less often."""
RECOVER_S = 2.0
MOST_WAITING = 16
NOT_HELD = "the servo driver has not said yet that it holds"


@dataclass(frozen=True, slots=True)
class Waiting:
    """A command that waits for what the servo driver answers."""

    call: Call
    asked: Asked


class Joints(Capability[JointsSettings]):
    """Joints operation: every decision is the kernel's, every message passes here."""

    _state: State
    _loop: LoopStatistics | None

    def __init__(self, ctx: Context[JointsSettings]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.rate_hz
        self._begin()

    def open(self) -> None:
        """Begin with nobody holding the joints, and silent until it is known what the servos do."""
        self._begin()
        self._listen()
        self._report()

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
        """Decide a command now; what the servos are to recover from is for their driver to say."""
        self._listen()
        match call.name:
            case "stop":
                self._decide(_stop(call), call)
            case "command":
                self._decide(_motion(call, call.message), call)
            case "move":
                self._decide(_motion(call, asked.of_move(call.message)), call)
            case "torque":
                self._decide(_torque(call), call)
            case "recover":
                self._recover(call, call.message)
            case _:
                call.refuse(f"{call.name} is not understood here", "unknown_command")
        self._report()

    def close(self) -> None:
        """Hold every joint and say that their mover is gone; end what was going on."""
        while self._waiting:
            self._waiting.popleft().call.refuse("joints operation ends", "shutting_down")
        now = self.ctx.clock()
        self._decide(Stop(source=self.ctx.name, received=now, reason="joints operation ends"))
        self._state = replace(self._state, lost=True)
        if self._state.adopted:
            self.ctx.publish("setpoint", setpoint(self._state).message)
        self._report()

    def _begin(self) -> None:
        self._state = first_state(self.ctx.settings, body(self.ctx.rows(Joint)), self.ctx.clock())
        self._beat = Beat(self.rate_hz)
        self._sweeps = Beat(self.rate_hz)
        self._meter = LoopMeter(self.rate_hz)
        self._loop = None
        self._waiting: deque[Waiting] = deque()
        self._servos_at = -inf
        self._servos_alive = False
        self._alive_holder = ""
        self._reported: JointsState | None = None
        self._reported_at = -inf

    def _listen(self) -> None:
        estop = self.ctx.estop
        if estop.engaged != self._state.holding.estop:
            self._decide(EstopChanged(engaged=estop.engaged, reason=estop.reason))
        self._listen_to_servos()
        self._watch_holder()
        if estop.engaged:
            held = self._holds()
            estop.acknowledge(stopped=held, reason="" if held else NOT_HELD)

    def _listen_to_servos(self) -> None:
        sources = self.ctx.sources("servos")
        alive = any(self.ctx.alive(source) for source in sources)
        if self._servos_alive and not alive:
            self._decide(ServosLost(reason=f"the servo driver ({', '.join(sources)}) is gone"))
        self._servos_alive = alive
        newest = self.ctx.latest("servos")
        if newest is not None and newest.arrived > self._servos_at:
            self._servos_at = newest.arrived
            self._decide(ServosSeen(servos=newest.message, arrived=newest.arrived))

    def _watch_holder(self) -> None:
        """End the motion of a capability whose process is gone; of others only the lease tells."""
        hold = self._state.holding.hold
        holder = hold.source if hold is not None else ""
        alive = bool(holder) and self.ctx.alive(holder)
        if holder and holder == self._alive_holder and not alive:
            self._decide(HolderGone(source=holder))
        self._alive_holder = holder if alive else ""

    def _recover(self, call: Call, command: RecoverCommand) -> None:
        joints = self._state.body.joints
        wrong = next((why for name in command.joints if (why := self._state.body.unknown(name))), None)
        if wrong:
            call.refuse(wrong)
        elif len(self._waiting) >= MOST_WAITING:
            call.refuse("too many commands wait for the servo driver; send fewer", "busy")
        else:
            ids = tuple(joints[name].device_id for name in command.joints or joints)
            answer = self.ctx.ask("servos_recover", RecoverServos(ids=ids), timeout_s=RECOVER_S)
            self._waiting.append(Waiting(call, answer))
            self._settle()

    def _settle(self) -> None:
        """Answer those whose question the servo driver has answered, in the order they came."""
        while self._waiting:
            answers = self._waiting[0].asked.answers()
            if answers is None:
                return
            _pass_on(self._waiting.popleft().call, list(answers.values()))

    def _decide(self, event: Event, call: Call | None = None) -> None:
        self._state, outputs = decide(self._state, event, self.ctx.clock())
        for output in outputs:
            match output:
                case Setpoint(message=message):
                    self.ctx.publish("setpoint", message)
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
        """Tell how the joints are: at each sweep, as fast as the loop goes; and whenever something else changed."""
        now = self.ctx.clock()
        state, last = self._state, self._reported
        period_s = STATE_PERIOD_S if state.holding.hold is None else MOVING_PERIOD_S
        swept = state.servos is not None and (last is None or state.servos.sweep != last.sequence)
        if (swept and self._sweeps.due(now)) or now - self._reported_at >= period_s or self._news():
            self._reported, self._reported_at = joints_state(state, now, self._loop), now
            self.ctx.publish("state", self._reported)

    def _news(self) -> bool:
        last, holding = self._reported, self._state.holding
        holder = holding.hold.source if holding.hold is not None else None
        goal = holding.hold.motion.goal if holding.hold is not None else None
        return last is None or (last.holder, last.goal, last.estop) != (holder, goal, holding.estop)

    def _holds(self) -> bool:
        """Say whether nothing moves any more: by what the driver says, if it is there."""
        servos = self._state.servos
        if self._state.move is not None:
            return False
        if servos is None:
            return not self._servos_alive
        return servos.estop or servos.phase in {"holding", "released"}


def _motion(call: Call, command: JointsCommand) -> Command:
    return Command(
        command=command,
        source=call.source,
        new_lease=secrets.token_hex(8),
        new_goal=f"goal-{secrets.token_hex(4)}",
        received=call.arrived,
        remote=call.remote,
        sender_s=call.sender_s,
        waited_s=call.waited_s,
        answerable=call.answerable,
    )


def _stop(call: Call) -> Stop:
    """Return a stop; a name that comes from another machine proves nothing, so that nobody is lost by it."""
    lost = call.message.lost and not call.remote
    said = call.message
    return Stop(source=call.source, received=call.arrived, reason=said.reason, lost=lost, whole=said.whole)


def _torque(call: Call) -> Torque:
    return Torque(
        command=call.message,
        source=call.source,
        received=call.arrived,
        remote=call.remote,
        answerable=call.answerable,
    )


def _pass_on(call: Call, answers: list[object]) -> None:
    """Answer with what the servo driver said."""
    found = [answer for answer in answers if isinstance(answer, CommandReply)]
    if not found or len(found) < len(answers):
        call.refuse("the servo driver did not answer; is it running?", "unreachable")
        return
    reasons = "; ".join(answer.reason for answer in found if answer.reason)
    code = next((answer.code for answer in found if not answer.accepted), "")
    call.reply(CommandReply(accepted=all(answer.accepted for answer in found), reason=reasons, code=code))
