"""The servo bus as a capability: setpoints in, coherent states out, and the last word on whether a servo has torque."""

import queue
import sys
from concurrent.futures import Future
from math import inf

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.drivers.dynamixel import DynamixelSettings
from lbr.drivers.dynamixel.line import open_servo_line
from lbr.drivers.dynamixel.recovery import recovery
from lbr.drivers.dynamixel.session import NOTABLE_BYTES, Session
from lbr.drivers.dynamixel.sweep import Snapshot
from lbr.drivers.dynamixel.view import servo_state, statistics
from lbr.drivers.guard import WOKEN
from lbr.drivers.mover import first, receive, strength, tick
from lbr.drivers.owner import READ, WRITE
from lbr.errors import DeviceError
from lbr.messages.leases import CommandReply
from lbr.messages.servos import RecoverServos, ServoPhase, ServosState

SWITCH_S = 1e-4
"""The loop's thread may keep the bus's thread waiting no longer than this."""
SILENT_S = 1.5
PUBLISH_S = 0.1
CONFIRM_S = 0.05
NAMED = 3
LOST_S = 1.0
"""Whoever moves the servos may stumble for so long before anybody is told."""


class Dynamixel(Capability[DynamixelSettings]):
    """Applies fresh setpoints to the servos that the rows name; in every doubt they hold, and are let go slowly."""

    rate_hz = 100.0

    def __init__(self, ctx: Context[DynamixelSettings]) -> None:
        super().__init__(ctx)
        self._joints = {joint.device_id: joint.name for joint in ctx.joints}
        self._mover = first(ctx.clock())
        self._session: Session | None = None
        self._told: queue.SimpleQueue[tuple[str, str, str]] = queue.SimpleQueue()
        self._recovering: list[tuple[Call, dict[int, Future[str]]]] = []
        self._snapshot = Snapshot(0, -inf, {})
        self._estopped = False
        self._left_on = False
        self._lost = False
        self._asked_at = -inf
        self._published = -inf
        self._shown: tuple[object, ...] = ()
        self._warned: str | None = None

    def open(self) -> None:
        """Open the line and begin to look for the servos; nothing is switched on, and nothing moves."""
        settings = self.ctx.settings
        if self.ctx.device is None:
            raise DeviceError(f"'{self.ctx.name}' has no device row '{settings.device}'; add it")
        if not self._joints:
            raise DeviceError(f"'{self.ctx.name}' has no servos: the table joint has no rows for this robot; add them")
        sys.setswitchinterval(SWITCH_S)
        line = open_servo_line(self.ctx.device, settings.baud, settings.reply_margin_s)
        self._mover = first(self.ctx.clock())
        self._session = Session(self.ctx, line, list(self._joints), self._tell)
        self._session.owner.start()
        self._warned = None

    def step(self) -> None:
        """Decide, tell the servos what follows, answer, and tell the others."""
        session = self._session
        assert session is not None
        self._check(session)
        self._listen()
        now = self.ctx.clock()
        settings = self.ctx.settings
        estop = self.ctx.estop
        self._mover = tick(
            self._mover, now, settings.setpoint_valid_s, self._gone(), estop.reason if estop.engaged else None
        )
        if estop.engaged and settings.on_estop == "release" and session.outputs.turning:
            session.outputs.release("the emergency stop let it go; switch its torque off, then on")
        snapshot = self._snapshot = session.sweeper.snapshot
        session.outputs.apply(self._mover, self._strength(now), snapshot)
        session.beat()
        session.judge()
        self._heed_estop(session, now)
        self._answer_recoveries()
        if snapshot.searched:  # before, silence is all that can be said of who has torque
            self._tell_of_loss(session, now)
            self._report()
            self._publish_when_due(session, now)

    def command(self, call: Call) -> None:
        """Recover servos; the answer comes when all of them were tried."""
        session, message = self._session, call.message
        if not isinstance(message, RecoverServos):
            super().command(call)
            return
        if session is None:
            call.refuse(f"device '{self.ctx.settings.device}' is away")
            return
        unknown = [servo for servo in message.ids if servo not in self._joints]
        if unknown:
            call.refuse(f"no joint has servo {unknown[0]}; there are {', '.join(map(str, self._joints))}")
            return
        jobs = {}
        for servo, out in session.outputs.servos.items():
            kept = session.setup.kept.get(servo)
            if out.latched and kept is not None and servo in (message.ids or self._joints):
                jobs[servo] = session.owner.submit(recovery(servo, kept), WRITE)
        if not jobs:
            call.reply(CommandReply(accepted=True, reason="no servo has latched a fault"))
            return
        self._recovering.append((call, jobs))

    def degraded(self, reason: str) -> None:
        """Tell that the bus is away."""
        if self.ctx.estop.engaged:
            self.ctx.estop.acknowledge(stopped=False, reason=reason)
        for call, _ in self._recovering:
            call.refuse(reason)
        self._recovering.clear()
        self._publish(None, reason)

    def close(self) -> None:
        """Have the servos hold, or let them go, as the row says; then let go of the line. A guard has the last word."""
        session, self._session = self._session, None
        if session is not None:
            self._left_on = session.outputs.turning
            session.close(release=self.ctx.settings.on_close == "release")

    def _check(self, session: "Session") -> None:
        failure = session.owner.failure
        if isinstance(failure, DeviceError):
            raise failure
        if failure is not None:
            raise RuntimeError("the bus's thread ended") from failure
        if session.guard is not None and not session.guard.standing:
            raise DeviceError(f"device '{self.ctx.settings.device}': its guard process died or hangs; opening anew")
        if session.guard is not None and session.guard.woken():
            self.ctx.event("guard", WOKEN, level="warning")
        seen = session.sweeper.snapshot.servos.values()
        if self.ctx.clock() - max(session.opened, session.sweeper.heard) > SILENT_S and all(one.reason for one in seen):
            counts = session.bus.counts
            said = f"babbles ({counts.babble} bytes that mean nothing), and " if counts.babble > NOTABLE_BYTES else ""
            raise DeviceError(
                f"device '{self.ctx.settings.device}': {said}none of its {len(self._joints)} servos answers; "
                f"is their power on? Check the cable, and the row's baud ({self.ctx.settings.baud})"
            )

    def _listen(self) -> None:
        sources, valid_s = self.ctx.sources("setpoint"), self.ctx.settings.setpoint_valid_s
        for received in self.ctx.take("setpoint"):
            if received.source in sources:
                now = self.ctx.clock()
                self._mover = receive(self._mover, received.message, received.arrived, now, valid_s)

    def _gone(self) -> str:
        sources = self.ctx.sources("setpoint")
        if not sources:
            return "no source is wired to the setpoint"
        return "" if any(self.ctx.alive(source) for source in sources) else f"'{sources[0]}' is not on the bus"

    def _strength(self, now: float) -> float:
        return strength(self._mover, now, self.ctx.settings.hold_s, self.ctx.settings.release_s)

    def _heed_estop(self, session: "Session", now: float) -> None:
        """Acknowledge when every servo was read to hold where it is, or to be without torque."""
        estop = self.ctx.estop
        if not estop.engaged:
            if self._estopped:
                self._estopped = False
                estop.acknowledge(stopped=False, reason="released")
            return
        self._estopped = True
        released = self.ctx.settings.on_estop == "release"
        left = session.outputs.unconfirmed(self._snapshot, released=released)
        if left and now - self._asked_at >= CONFIRM_S:
            self._asked_at = now
            session.owner.submit(lambda _bus: session.sweeper.look(left), READ, key="confirm")
        known = self._snapshot.searched
        why = (
            self._named(left, "not confirmed by") if left else "" if known else "the servos are still being looked for"
        )
        estop.acknowledge(stopped=known and not left, reason=why)

    def _named(self, servos: list[int], what: str) -> str:
        some = ", ".join(f"{self._joints[servo]} (servo {servo})" for servo in servos[:NAMED])
        return f"{what} {some}" + (f" and {len(servos) - NAMED} more" if len(servos) > NAMED else "")

    def _answer_recoveries(self) -> None:
        session = self._session
        assert session is not None
        waiting = []
        for call, jobs in self._recovering:
            if not all(job.done() for job in jobs.values()):
                waiting.append((call, jobs))
                continue
            failed = []
            for servo, job in jobs.items():
                wrong = "was not asked" if job.cancelled() else job.result()
                if wrong:
                    failed.append(f"{self._joints[servo]} (servo {servo}) {wrong}")
                else:
                    session.outputs.recovered(servo)
            if failed:
                call.refuse("; ".join(failed))
            else:
                said = self._named(list(jobs), "recovered, without torque:")
                call.reply(CommandReply(accepted=True, reason=said))
        self._recovering = waiting

    def _tell(self, kind: str, text: str, level: str) -> None:
        """Keep an event for the loop's thread."""
        self._told.put((kind, text, level))

    def _tell_of_loss(self, session: "Session", now: float) -> None:
        """Tell what becomes of servos that nobody cares for, and when it has."""
        since, settings = self._mover.lost_since, self.ctx.settings
        if since is None:
            self._lost = False
        elif not self._lost and session.outputs.turning and now - since >= LOST_S:
            self._lost = True
            left = f"hold for {max(0.0, settings.hold_s + since - now):.0f} s and are then let go"
            self.ctx.event(
                "mover_lost",
                f"{self._mover.reason}: the servos {left}; a motion or /torque/on keeps them",
                level="warning",
            )
        elif self._lost and not session.outputs.turning:
            self._lost = False
            self.ctx.event("let_go", "nobody cared for the servos: they have no torque now", level="warning")

    def _report(self) -> None:
        while not self._told.empty():
            kind, text, level = self._told.get()
            self.ctx.event(kind, text, level=level)
        away = [servo for servo, seen in self._snapshot.servos.items() if seen.reason]
        wrong = self._named(away, "cannot be used:") if away else ""
        if wrong != self._warned:
            self._warned = wrong
            if wrong:
                self.ctx.warn(wrong)
            else:
                self.ctx.ready()

    def _phase(self) -> ServoPhase:
        session, now = self._session, self.ctx.clock()
        if session is None or not session.outputs.turning:
            return "released"
        if self._mover.follows:
            return "following"
        return "releasing" if self._strength(now) < 1.0 else "holding"

    def _publish_when_due(self, session: "Session", now: float) -> None:
        shown = (
            self._snapshot.sweep,
            self._phase(),
            self._mover.reason,
            self.ctx.estop.engaged,
            self._mover.halt,
        )
        if shown != self._shown or now - self._published >= PUBLISH_S:
            self._shown = shown
            self._publish(session)

    def _publish(self, session: "Session | None", away: str = "") -> None:
        now = self._published = self.ctx.clock()
        mover = self._mover
        if session is None:
            state = ServosState(
                sweep=0, measured_s=now, armed=False, phase="holding" if self._left_on else "released", servos=(), reason=away,
                estop=self.ctx.estop.engaged, halt=mover.halt or 0,
            )  # fmt: skip
            self.ctx.publish("state", state)
            return
        snapshot = self._snapshot
        inhibited = mover.estop or bool(self._gone())
        self.ctx.publish(
            "state",
            ServosState(
                sweep=snapshot.sweep,
                measured_s=snapshot.ended if snapshot.sweep else now,
                armed=not inhibited,
                phase=self._phase(),
                servos=tuple(servo_state(out, snapshot.servos[out.id], now) for out in session.outputs.servos.values()),
                reason=mover.reason,
                estop=self.ctx.estop.engaged,
                halt=mover.halt or 0,
                bus=statistics(session.bus, snapshot),
            ),
        )
