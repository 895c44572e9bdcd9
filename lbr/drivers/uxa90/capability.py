"""The line of a UXA-90 as a capability: setpoints in, coherent states out, and the last word on who has torque."""

import queue
import sys
from math import inf

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.drivers.guard import WOKEN
from lbr.drivers.mover import bury, ended, first, receive, strength, tick
from lbr.drivers.uxa90 import Uxa90Settings
from lbr.drivers.uxa90.answering import Answering
from lbr.drivers.uxa90.plays import Plays
from lbr.drivers.uxa90.session import SILENT_S, Session
from lbr.drivers.uxa90.stopping import Stopping
from lbr.drivers.uxa90.view import MEASURED_S, servo_state, statistics
from lbr.errors import DeviceError
from lbr.messages.leases import CommandReply
from lbr.messages.servos import RecoverServos, ServoPhase, ServosState, StoredPlay
from lbr.messages.uxa90 import ControllerState, TakeControlCommand

SWITCH_S = 1e-4
"""The loop's thread may keep the line's thread waiting no longer than this."""
RETAKE_S = 3.0
BLIND_S = 1.5
"""So long after PC control was taken it may take until it is known where the servos are."""
PUBLISH_S = 0.1
CONTROLLER_S = 0.5
LOST_S = 1.0
WARN_EVERY_S = 2.0
NAMED = 3
CONTACT = "was out of reach: was it without power? Switch its torque off, then on"


class Uxa90(Capability[Uxa90Settings]):
    """Applies fresh setpoints to the servos that the rows name; in every doubt they hold, and are let go slowly."""

    rate_hz = 100.0

    def __init__(self, ctx: Context[Uxa90Settings]) -> None:
        super().__init__(ctx)
        self._joints = {joint.device_id: joint.name for joint in ctx.joints}
        self._mover = first(ctx.clock())
        self._session: Session | None = None
        self._plays = Plays()
        self._asked: StoredPlay | None = None
        self._contact_lost = ""
        self._told: queue.SimpleQueue[tuple[str, str, str]] = queue.SimpleQueue()
        self._stopping = Stopping(ctx, self._joints)
        self._answering = Answering(ctx, self._joints)
        self._passed_since = inf
        self._known = False
        self._retaken_at = -inf
        self._left_on = self._lost = False
        self._published = self._controller_at = self._warned_at = -inf
        self._shown: tuple[object, ...] = ()
        self._warned: str | None = None

    def open(self) -> None:
        """Open the line and take PC control, which moves nothing; nothing is switched on."""
        settings = self.ctx.settings
        if self.ctx.device is None:
            raise DeviceError(f"'{self.ctx.name}' has no device row '{settings.device}'; add it")
        if not self._joints:
            raise DeviceError(f"'{self.ctx.name}' has no servos: the table joint has no rows for this robot; add them")
        sys.setswitchinterval(SWITCH_S)
        self._mover, self._asked = first(self.ctx.clock()), None
        self._session = Session(self.ctx, list(self._joints), self._tell, self._plays, self._contact_lost)
        self._passed_since, self._known, self._retaken_at = inf, False, -inf
        self._warned, self._warned_at = None, -inf

    def step(self) -> None:
        """Decide, tell the servos what follows, answer, and tell the others."""
        session = self._session
        assert session is not None
        now, settings, estop = self.ctx.clock(), self.ctx.settings, self.ctx.estop
        session.step()
        self._check(session, now)
        self._listen()
        halts = self._mover.halts
        self._mover = tick(
            self._mover, now, settings.setpoint_valid_s, self._gone(), estop.reason if estop.engaged else None
        )
        session.controller.step(self._mover, self._asked)
        self._plays = session.controller.plays
        self._stopping.step(session, now)
        if not session.controller.occupied:
            session.outputs.apply(self._mover, self._strength(now))
        session.tell(urgent=not self._mover.follows or self._mover.halts != halts)
        session.beat()
        session.judge()
        self._answering.step(session)
        self._tell_of_loss(session, now)
        self._report(session, now)
        self._publish_when_due(session, now)

    def command(self, call: Call) -> None:
        """Answer a command; what needs the line, when that has answered."""
        session = self._session
        if session is None:
            call.refuse(f"device '{self.ctx.settings.device}' is away")
        elif isinstance(call.message, RecoverServos):
            call.reply(CommandReply(accepted=True, reason="these servos report no faults, so that none is latched"))
        elif isinstance(call.message, TakeControlCommand):
            self._answering.take_control(call, session)
        else:
            self._answering.ask(call, session, moving=self._mover.follows and bool(self._mover.lease))

    def degraded(self, reason: str) -> None:
        """Tell that the line is away."""
        if self.ctx.estop.engaged:
            self.ctx.estop.acknowledge(stopped=False, reason=reason)
        self._answering.refuse(reason)
        self._publish_away(reason)

    def close(self) -> None:
        """Have the servos hold, or let them go, as the row says; then let go of the line. A guard has the last word."""
        session, self._session = self._session, None
        if session is not None:
            self._left_on = session.outputs.turning
            if session.owner.failure is not None:
                self._contact_lost = CONTACT
            session.close(release=self.ctx.settings.on_close == "release")
            self._plays = session.controller.plays

    def _check(self, session: Session, now: float) -> None:
        """Raise what ends the session; look whether anybody answers."""
        device, failure = self.ctx.settings.device, session.owner.failure
        if isinstance(failure, DeviceError):
            raise failure
        if failure is not None:
            raise RuntimeError("the line's thread ended") from failure
        if session.guard is not None and not session.guard.standing:
            raise DeviceError(f"device '{device}': its guard process died or hangs; opening anew")
        if session.guard is not None and session.guard.woken():
            self.ctx.event("guard", WOKEN, level="warning")
        sweeper, controller = session.sweeper, session.controller
        if not (controller.passes and sweeper.reading):
            self._passed_since = inf
            return
        self._passed_since = min(self._passed_since, now)
        waited = now - self._passed_since > BLIND_S or not self.ctx.settings.sweep_hz
        self._known = self._known or sweeper.told_apart or waited
        silent_s = now - max(sweeper.heard, self._passed_since)
        if not session.mute or silent_s < SILENT_S or now - self._retaken_at < RETAKE_S:
            return
        if sweeper.heard > max(self._retaken_at, session.opened):
            self._retaken_at = now
            self._mover = ended(self._mover, "no servo answered; PC control was taken again")
            session.outputs.loose(self._mover.goals)
            controller.lost()
        elif sweeper.heard > session.opened:
            self._contact_lost = CONTACT
            raise DeviceError(
                f"device '{device}': none of its {len(self._joints)} servos answers any more; is the robot's power on? "
                f"Check the cable, and the row's baud ({self.ctx.settings.baud})"
            )
        else:
            self._retaken_at = now
            controller.lost()

    def _listen(self) -> None:
        sources, valid_s = self.ctx.sources("setpoint"), self.ctx.settings.setpoint_valid_s
        for received in self.ctx.take("setpoint"):
            if received.source in sources:
                now, before = self.ctx.clock(), self._mover
                if not before.seen:  # what began before the line was open does not go on
                    before = bury(before, received.message.lease)
                self._mover = receive(before, received.message, received.arrived, now, valid_s)
                if self._mover is not before:
                    self._asked = received.message.stored

    def _gone(self) -> str:
        sources = self.ctx.sources("setpoint")
        if not sources:
            return "no source is wired to the setpoint"
        return "" if any(self.ctx.alive(source) for source in sources) else f"'{sources[0]}' is not on the bus"

    def _strength(self, now: float) -> float:
        return strength(self._mover, now, self.ctx.settings.hold_s, self.ctx.settings.release_s)

    def _tell(self, kind: str, text: str, level: str) -> None:
        """Keep an event for the loop's thread."""
        self._told.put((kind, text, level))

    def _tell_of_loss(self, session: Session, now: float) -> None:
        """Tell what becomes of servos that nobody cares for, and when it has."""
        since, settings = self._mover.lost_since, self.ctx.settings
        if since is None:
            self._lost = False
        elif not self._lost and session.outputs.turning and now - since >= LOST_S:
            self._lost = True
            left = f"hold for {max(0.0, settings.hold_s + since - now):.0f} s and are then let go"
            text = f"{self._mover.reason}: the servos {left}; a motion or /torque/on keeps them"
            self.ctx.event("mover_lost", text, level="warning")
        elif self._lost and not session.outputs.turning:
            self._lost = False
            self.ctx.event("let_go", "nobody cared for the servos: they have no torque now", level="warning")

    def _report(self, session: Session, now: float) -> None:
        while not self._told.empty():
            kind, text, level = self._told.get()
            self.ctx.event(kind, text, level=level)
        wrong = self._wrong(session)
        if wrong != self._warned and now - self._warned_at >= WARN_EVERY_S:
            self._warned, self._warned_at = wrong, now
            if wrong:
                self.ctx.warn(wrong)
            else:
                self.ctx.ready()

    def _wrong(self, session: Session) -> str:
        seen = session.sweeper.seen
        away = [servo for servo, one in seen.items() if one.reason]
        if len(away) == len(seen):
            return "no servo answers, so that nothing is measured; is the robot's power on?"
        some = ", ".join(f"{self._joints[servo]} (servo {servo})" for servo in away[:NAMED])
        more = f" and {len(away) - NAMED} more" if len(away) > NAMED else ""
        return f"not measured: {some}{more}; check cable and power" if away else ""

    def _phase(self, session: Session, now: float) -> ServoPhase:
        if not self._mover.seen and session.outputs.unknown and not self._contact_lost:
            return "holding"  # what whoever moved them before left with torque; after a loss of contact nothing goes on
        if not session.outputs.turning and not session.controller.occupied:
            return "released"
        if self._mover.follows:
            return "following"
        return "releasing" if self._strength(now) < 1.0 else "holding"

    def _inhibited(self) -> str:
        """Say why no setpoint would be applied, or nothing."""
        if self._mover.estop or self._gone():
            return self._mover.reason or self._gone()
        return "" if self._known else "PC control is being taken, and the servos are looked for"

    def _publish_when_due(self, session: Session, now: float) -> None:
        stored = session.controller.plays.state()
        mode = session.controller.mode.name
        shown = (
            session.sweeper.sweep, self._phase(session, now), self._mover.reason, self.ctx.estop.engaged,
            self._mover.halt, stored, mode, self._known,
        )  # fmt: skip
        if shown != self._shown or now - self._published >= PUBLISH_S:
            changed_mode = not self._shown or self._shown[6] != mode
            self._shown = shown
            self._publish(session, now)
            if changed_mode or now - self._controller_at >= CONTROLLER_S:
                self._controller_at = now
                self._publish_controller(session)

    def _publish(self, session: Session, now: float) -> None:
        self._published = now
        sweeper, outputs, inhibited = session.sweeper, session.outputs, self._inhibited()
        self.ctx.publish(
            "state",
            ServosState(
                sweep=sweeper.sweep,
                measured_s=sweeper.ended if sweeper.sweep else now,
                armed=not inhibited,
                phase=self._phase(session, now),
                servos=tuple(servo_state(outputs, out, sweeper.seen[out.id], now) for out in outputs.servos.values()),
                reason=self._mover.reason or inhibited,
                estop=self.ctx.estop.engaged,
                halt=self._mover.halt or 0,
                stores=True,
                stored=session.controller.plays.state(),
                mode=session.controller.mode.name,
                tells_torque=False,
                bus=statistics(session.bus, sweeper),
            ),
        )

    def _publish_controller(self, session: Session) -> None:
        seen, counts, trust = session.sweeper.seen.values(), session.bus.counts, self.ctx.settings.trust
        trusted = sum(one.trusted and self.ctx.clock() - one.at < MEASURED_S for one in seen)
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
                missing=counts.missing,
                implausible=sum(one.implausible for one in seen),
                strays=counts.strays,
            ),
        )

    def _publish_away(self, reason: str) -> None:
        now = self._published = self.ctx.clock()
        self.ctx.publish(
            "state",
            ServosState(
                sweep=0, measured_s=now, armed=False, phase="holding" if self._left_on else "released", servos=(),
                reason=reason, estop=self.ctx.estop.engaged, halt=self._mover.halt or 0, stores=True,
                stored=self._plays.state(), mode="unknown", tells_torque=False,
            ),
        )  # fmt: skip
        self.ctx.publish("controller", ControllerState(mode="unknown", reason=reason))
