"""The process around the joints kernel: it passes arrivals and the time to the kernel, and publishes the outputs."""

from functools import partial
from math import inf

from msgspec.structs import replace

from lbr.capability.context import Call, Context, Received
from lbr.messages.codes import Reason
from lbr.messages.joints import Joint, JointsCommand, JointsState, RecoverCommand
from lbr.messages.leases import CommandReply
from lbr.messages.servos import RecoverServos
from lbr.operations.joints import request
from lbr.operations.joints.body import body
from lbr.operations.joints.kernel import decide
from lbr.operations.joints.moving import setpoint
from lbr.operations.joints.settings import JointsSettings
from lbr.operations.joints.state import (
    NOT_ADOPTED,
    Command,
    Event,
    HolderGone,
    Outputs,
    ServosLost,
    ServosSeen,
    State,
    Tick,
    Torque,
    first_state,
    servos_trouble,
)
from lbr.operations.joints.view import joints_state
from lbr.operations.lender import Answers, LeasingCapability, marked, new_goal, origin_of
from lbr.operations.statistics import Beat

STATE_PERIOD_S = 0.1
REST_HZ = 10.0
"""The setpoints a second while the servos rest without a holder: their driver then trusts one for 0.3 s."""
MOVING_PERIOD_S = 0.045
"""The greatest period of the state while joints move, even if their servos are read less often."""
RECOVER_S = 2.0
NOT_HELD = "the servo driver has not confirmed yet that it holds"


class Joints(LeasingCapability[JointsSettings, State]):
    """Joints operation: every decision is the kernel's, every message passes here."""

    ends, driver, tick = "joints operation ends", "servos", Tick()
    feeds = ("servos",)

    def __init__(self, ctx: Context[JointsSettings]) -> None:
        super().__init__(ctx)
        self.begin()

    def open(self) -> None:
        """Start without a holder of the joints, and without setpoints until the servos' state is known."""
        self.begin()

    def step(self) -> None:
        """Process arrived messages, and do a round when it is due, slowly while nothing moves."""
        self.listen()
        rate_hz = min(REST_HZ, self.ctx.settings.rate_hz) if self._rests() else self.ctx.settings.rate_hz
        if rate_hz != self.rate_hz:
            self.rate_hz = rate_hz
            self.keep_time()
        super().step()

    def close(self) -> None:
        """Publish a hold of every joint with a lost mover; end the current motion."""
        super().close()
        self._state = replace(self._state, lost=True)
        if self._state.adopted:
            self.ctx.publish("setpoint", marked(setpoint(self._state).message))

    def begin(self) -> None:
        """Start without a lease."""
        self.rate_hz = self.ctx.settings.rate_hz
        super().begin()
        self._sweeps = Beat(self.rate_hz)
        self._ordered: tuple[object, ...] = ()
        self._reported: JointsState | None = None
        self._reported_at = -inf

    def first(self) -> State:
        """Return the state of joints that were not moved yet."""
        return first_state(self.ctx.settings, body(self.ctx.rows(Joint)), self.ctx.clock())

    def decide(self, event: Event, now: float) -> tuple[State, Outputs]:
        """Return the kernel's decision on an event."""
        return decide(self._state, event, now)

    def driver_seen(self, received: Received) -> ServosSeen:
        """Return the event for a state of the servo driver."""
        return ServosSeen(servos=received.message, arrived=received.arrived)

    def driver_lost(self, names: str) -> ServosLost:
        """Return the event for a lost servo driver."""
        return ServosLost(reason=f"the servo driver ({names}) is gone")

    def holder_gone(self, holder: str) -> HolderGone:
        """Return the event for a holder whose process is gone; motions of others continue."""
        return HolderGone(source=holder)

    def lend(self, call: Call) -> None:
        """Decide a command now; a recovery is forwarded to the servo driver."""
        match call.name:
            case "command":
                self.happen(_motion(call, call.message), call)
            case "move":
                self.happen(_motion(call, request.of_move(call.message)), call)
            case "torque":
                self.happen(_torque(call), call)
            case "recover":
                self._recover(call, call.message)
            case _:
                super().lend(call)

    def not_at_rest(self) -> str:
        """Return a sentence if something may still move by the driver's state, or an empty string."""
        servos = self._state.servos
        held = not self._driver_alive if servos is None else servos.estop or servos.phase in {"holding", "released"}
        return "" if held else NOT_HELD

    def trouble(self) -> Reason | None:
        """Return why no servo would follow, or that the torque of servos is unknown yet; or None."""
        why = servos_trouble(self._state, self.ctx.clock())
        return why or (None if self._state.adopted else NOT_ADOPTED)

    def _rests(self) -> bool:
        """Return whether the driver needs no setpoint soon: its servos rest, and have no new order."""
        state, before = self._state, self._ordered
        self._ordered = state.on, state.goals, state.strength, state.lost, state.halt
        moved = state.leases.live or state.leases.offers or state.feet or state.leases.estop
        rests = state.servos is not None and state.servos.rests and state.adopted
        return rests and not moved and before == self._ordered

    def _recover(self, call: Call, command: RecoverCommand) -> None:
        joints = self._state.body.joints
        if wrong := next((why for name in command.joints if (why := self._state.body.unknown(name))), None):
            call.refuse(wrong)
            return
        servos = RecoverServos(ids=tuple(joints[name].device_id for name in command.joints or joints))
        ask = partial(self.ctx.ask, "servos_recover", servos, timeout_s=RECOVER_S)
        self.wait_for(call, "the servo driver", ask, RECOVER_S, partial(_pass_on, call))

    def report(self) -> None:
        """Publish the state: at each sweep, as fast as the loop goes; and whenever something else changed."""
        now = self.ctx.clock()
        state, last = self._state, self._reported
        period_s = STATE_PERIOD_S if state.leases.live is None else MOVING_PERIOD_S
        swept = state.servos is not None and (last is None or state.servos.sweep != last.sequence)
        if (swept and self._sweeps.due(now)) or now - self._reported_at >= period_s or self._news():
            self._reported, self._reported_at = joints_state(state, now, self._loop), now
            self.ctx.publish("state", self._reported)

    def _news(self) -> bool:
        last, leases = self._reported, self._state.leases
        holder = leases.live.source if leases.live is not None else None
        goal = leases.live.motion.goal if leases.live is not None else None
        return last is None or (last.holder, last.goal, last.estop) != (holder, goal, leases.estop)


def _motion(call: Call, command: JointsCommand) -> Command:
    return Command(command=command, new_goal=new_goal(), **origin_of(call))


def _torque(call: Call) -> Torque:
    return Torque(
        command=call.message,
        source=call.source,
        received=call.arrived,
        remote=call.remote,
        answerable=call.answerable,
    )


def _pass_on(call: Call, answers: Answers) -> None:
    """Reply with the servo driver's answers."""
    replies = [answer for answer in (answers or {}).values() if isinstance(answer, CommandReply)]
    if not replies or len(replies) < len(answers or ()):
        call.refuse("the servo driver did not answer; is it running?", "unreachable")
        return
    reasons = "; ".join(answer.reason for answer in replies if answer.reason)
    code = next((answer.code for answer in replies if not answer.accepted), "")
    call.reply(CommandReply(accepted=all(answer.accepted for answer in replies), reason=reasons, code=code))
