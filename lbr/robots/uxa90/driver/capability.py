"""The line of a UXA-90 as a capability: the main board's part of a driver for servos that report no torque."""

from math import inf

from lbr.capability.context import Call, Context, Device
from lbr.drivers.servos.capability import Measured, Servos
from lbr.drivers.servos.gate import ended, receive
from lbr.errors import DeviceError
from lbr.messages.codes import Reason
from lbr.messages.leases import CommandReply
from lbr.messages.servos import RecoverServos, ServoPhase, ServoSetpoint, StoredPlay
from lbr.robots.uxa90.driver import Uxa90Settings
from lbr.robots.uxa90.driver.commands import Commands
from lbr.robots.uxa90.driver.estop import EmergencyStop
from lbr.robots.uxa90.driver.messages import ControllerState, TakeControlCommand
from lbr.robots.uxa90.driver.session import SILENT_S, Session
from lbr.robots.uxa90.driver.stored_motions import StoredMotions
from lbr.robots.uxa90.driver.view import MEASURED_S, servo_state, statistics

RETAKE_S = 3.0
BLIND_S = 1.5
"""The time after taking PC control by which the positions of the servos must be known."""
CONTROLLER_S = 0.5
LOOKED_FOR = "PC control is being taken, and the servos are looked for"
CONTACT = "was out of reach: was it without power? Switch its torque off, then on"


class Uxa90(Servos[Uxa90Settings, Session]):
    """The servos behind a UXA-90's main board, and its stored motions."""

    warn_every_s = 2.0

    def __init__(self, ctx: Context[Uxa90Settings]) -> None:
        super().__init__(ctx)
        self._plays = StoredMotions()
        self._asked: StoredPlay | None = None
        self._contact_lost = ""
        self._estop = EmergencyStop(ctx, self.named)
        self._commands = Commands(ctx, self._joints)
        self._passed_since = inf
        self._known = self._unanswered = False
        self._halts = 0
        self._retaken_at = self._controller_at = -inf

    def connected(self, device: Device, servos: list[int]) -> Session:
        """Open the line and take PC control, which moves nothing."""
        self._asked = None
        self._passed_since, self._known, self._unanswered, self._retaken_at = inf, False, False, -inf
        return Session(self.ctx, device, servos, self.tell, self._plays, self._contact_lost)

    def hear(self, session: Session) -> None:
        """Process the main board's frames; take control after the question about its identity."""
        session.step()

    def act(self, session: Session, now: float) -> None:
        """Send the orders to the main board and the servos."""
        session.controller.step(self._gate, self._asked)
        self._plays = session.controller.plays
        self._estop.step(session, now)
        if not session.controller.occupied:
            session.targets.apply(self._gate, self._strength(now))
        session.send_orders(urgent=not self._gate.follows or self._gate.halts != self._halts)
        self._halts = self._gate.halts

    def answer(self, session: Session) -> None:
        """Reply to the commands that waited for the line."""
        self._commands.step(session)

    def command(self, call: Call) -> None:
        """Handle a command; one that needs the line is replied to later."""
        session = self._session
        if session is None:
            call.refuse(f"device '{self.ctx.settings.device}' is away", "unreachable")
        elif isinstance(call.message, RecoverServos):
            call.reply(CommandReply(accepted=True, reason="these servos report no faults, so that none is latched"))
        elif isinstance(call.message, TakeControlCommand):
            self._commands.take_control(call, session)
        else:
            self._commands.ask(call, session, moving=self._gate.follows and bool(self._gate.lease))

    def refuse_waiting(self, reason: str) -> None:
        """Refuse the commands that wait for the line."""
        self._commands.refuse(reason)

    def close(self) -> None:
        """Close, and keep the state of the main board's motion, and whether contact with the servos was lost."""
        session = self._session
        if session is not None and session.failure is not None:
            self._contact_lost = CONTACT
        super().close()
        if session is not None:
            self._plays = session.controller.plays

    def check(self, session: Session, now: float) -> None:
        """Check for answers of servos; raise DeviceError if none answers any more."""
        device = self.ctx.settings.device
        poller, controller = session.poller, session.controller
        if not (controller.passes and poller.reading):
            self._passed_since = inf
            return
        self._passed_since = min(self._passed_since, now)
        waited = now - self._passed_since > BLIND_S or not self.ctx.settings.sweep_hz
        self._known = self._known or (self.answers() and (poller.judged_all or waited))
        answered = session.hears
        if answered and self._unanswered:
            self._unanswered = False
            self._begin_anew(session, "servos answer again, after commands that they may have missed")
        silent_s = now - max(poller.heard_at, self._passed_since)
        if not session.mute or silent_s < SILENT_S or now - self._retaken_at < RETAKE_S:
            return
        if not self.answers() or (answered and poller.heard_at <= self._retaken_at):
            self._contact_lost = CONTACT
            more = " any more" if answered else ""
            raise DeviceError(
                f"device '{device}': none of its {len(self._joints)} servos answers{more}; is the robot's power on? "
                f"Check the cable, and the row's baud ({self.ctx.settings.baud})"
            )
        self._retaken_at, self._unanswered = now, not answered
        if answered:
            self._begin_anew(session, "no servo answered; PC control was taken again")
        controller.lost()

    def _begin_anew(self, session: Session, why: str) -> None:
        """End the motion; servos with torque are held at their position, once that is read."""
        self._gate = ended(self._gate, why)
        session.targets.loose(self._gate.goals)

    def lacks(self) -> Reason | None:
        """Return that servos are still being searched for, or None."""
        return None if self._known else Reason("not_ready", LOOKED_FOR)

    def admit(self, setpoint: ServoSetpoint, arrived: float, now: float) -> None:
        """Pass a setpoint to the gate; motion from before the line was opened does not continue."""
        before = self._gate if self._gate.seen else self._gate.revoked(setpoint.lease)
        self._gate = receive(before, setpoint, arrived, now, self.ctx.settings.setpoint_valid_s)
        self.believe(before)
        if self._gate is not before:
            self._asked = setpoint.stored

    def unusable(self, session: Session) -> str:
        """Return a sentence about unmeasured servos, or an empty string."""
        seen = session.poller.seen
        away = [servo for servo, one in seen.items() if one.reason]
        if self._unanswered or len(away) == len(seen):
            return "no servo answers, so that nothing is measured; is the robot's power on?"
        return f"{self.named(away, 'not measured:')}; check cable and power" if away else ""

    def phase(self, session: Session | None, now: float) -> ServoPhase:
        """Return the phase of the servos; torque from before may still hold them, unless contact was lost."""
        if session is not None and not self._gate.seen and session.targets.unknown and not self._contact_lost:
            return "holding"
        occupied = session is not None and session.controller.occupied
        return self.energised_phase(now) if occupied else super().phase(session, now)

    def inhibited(self) -> str:
        """Return why a setpoint would not be applied now, or an empty string."""
        return super().inhibited() or ("" if self._known else LOOKED_FOR)

    def state_key(self, session: Session, now: float) -> tuple[object, ...]:
        """Return the values whose change is published at once; the main board's mode comes first."""
        gate, stored = self._gate, session.controller.plays.state()
        rests = session.rest.lasts
        seen = (session.poller.sweep, self.phase(session, now), rests, gate.reason, gate.halt, stored, self._known)
        return session.controller.mode.name, self.ctx.estop.engaged, *seen

    def published(self, session: Session, before: tuple[object, ...], now: float) -> None:
        """Publish the main board's state when its mode changes, and now and then."""
        if not before or before[0] != self._published_key[0] or now - self._controller_at >= CONTROLLER_S:
            self._controller_at = now
            self._publish_controller(session)

    def measured(self, session: Session, now: float) -> Measured:
        """Return the trusted readings of all servos, with their orders."""
        poller, targets = session.poller, session.targets
        servos = tuple(servo_state(targets, target, poller.seen[target.id], now) for target in targets.servos.values())
        return Measured(poller.sweep, poller.ended, servos, statistics(session.bus, poller))

    def common_state(self) -> dict[str, object]:
        """Return the fields of a state that need no line, those of the main board among them."""
        session = self._session
        board = {
            "stores": True,
            "stored": (self._plays if session is None else session.controller.plays).state(),
            "mode": "unknown" if session is None else session.controller.mode.name,
            "tells_torque": False,
        }
        return {**super().common_state(), **board}

    def degraded(self, reason: str) -> None:
        """Publish that the line is away, and the main board with it."""
        super().degraded(reason)
        self.ctx.publish("controller", ControllerState(mode="unknown", reason=reason))

    def _publish_controller(self, session: Session) -> None:
        seen, counts, trust = session.poller.seen.values(), session.bus.counts, self.ctx.settings.trust
        trusted = sum(servo.trusted and self.ctx.clock() - servo.at < MEASURED_S for servo in seen)
        why = f"{trusted} of {len(self._joints)} servos are believed" if trusted < len(self._joints) else ""
        self.ctx.publish(
            "controller",
            ControllerState(
                mode=session.controller.mode.name,
                firmware=session.identity.get("firmware", ""),
                serial=session.identity.get("serial", ""),
                trust=trusted == len(self._joints),
                reason="positions are not believed by the row's setting trust" if trust == "never" else why,
                replies=counts.replies,
                missing=counts.timeouts,
                implausible=sum(one.implausible for one in seen),
                strays=counts.babble,
            ),
        )
