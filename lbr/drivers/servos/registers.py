"""Servos whose torque, goal and limits can be read back: each order is checked, and repeated until it is in effect."""

from abc import abstractmethod
from collections.abc import Callable
from concurrent.futures import Future
from math import inf
from typing import Generic, TypeVar

from lbr.capability.context import Call, Context, Device
from lbr.drivers.servos import RegisterServosSettings
from lbr.drivers.servos.bus_thread import READ, WRITE
from lbr.drivers.servos.capability import Measured, Servos
from lbr.drivers.servos.contract import B, ServoLink, Snapshot
from lbr.drivers.servos.guard import Guard
from lbr.drivers.servos.session import NOTABLE_BYTES, ServoSession
from lbr.drivers.servos.view import servo_state, statistics
from lbr.errors import DeviceError
from lbr.messages.leases import CommandReply
from lbr.messages.servos import RecoverServos

SILENT_S = 1.5
CONFIRM_S = 0.05
S = TypeVar("S", bound=RegisterServosSettings)


class RegisterServos(Servos[S, ServoSession[S, B]], Generic[S, B]):
    """The capability for such servos; a driver adds `connect`."""

    def __init__(self, ctx: Context[S]) -> None:
        super().__init__(ctx)
        self._recovering: list[tuple[Call, dict[int, Future[str]]]] = []
        self._snapshot = Snapshot(0, -inf, {})
        self._estopped = False
        self._asked_at = -inf

    def guard(self, program: str, line: int, *words: object) -> Guard:
        """Start the guard of a line by its descriptor: `program` calls `guard_release.run` with `words` as its own
        arguments."""
        return Guard(program, line, self.ctx.settings, tuple(self._joints), self.ctx.clock, words=words)

    @abstractmethod
    def connect(self, device: Device, urgent: Callable[[], bool]) -> ServoLink[B]:
        """Open the line of a device row. The bus calls `urgent` to learn whether a stop waits; `self.tell` queues
        events."""

    def connected(self, device: Device, servos: list[int]) -> ServoSession[S, B]:
        """Open the line and begin to search for the servos."""
        return ServoSession(self.ctx, servos, lambda urgent: self.connect(device, urgent), self.tell)

    def check(self, session: ServoSession[S, B], now: float) -> None:
        """Raise DeviceError if no servo answers any more."""
        seen = session.poller.snapshot.servos.values()
        if now - max(session.opened, session.poller.heard_at) > SILENT_S and all(one.reason for one in seen):
            settings, babble = self.ctx.settings, session.bus.counts.babble
            babble_text = f"babbles ({babble} bytes that mean nothing), and " if babble > NOTABLE_BYTES else ""
            raise DeviceError(
                f"device '{settings.device}': {babble_text}none of its {len(self._joints)} servos answers; "
                f"is their power on? Check the cable, and the row's baud ({settings.baud})"
            )

    def act(self, session: ServoSession[S, B], now: float) -> None:
        """Send the servos their orders by the gate and their last readings."""
        if self.ctx.estop.engaged and self.ctx.settings.on_estop == "release" and session.turning:
            session.targets.release("the emergency stop let it go; switch its torque off, then on")
        snapshot = self._snapshot = session.poller.snapshot
        session.targets.apply(self._gate, self._strength(now), snapshot)
        self._heed_estop(session, now)

    def known(self) -> bool:
        """Return whether every servo was searched for; before that, a silent one may have torque."""
        return self._snapshot.searched

    def command(self, call: Call) -> None:
        """Recover servos; the reply comes after all of them were tried."""
        session, message = self._session, call.message
        if not isinstance(message, RecoverServos):
            super().command(call)
            return
        if session is None:
            call.refuse(f"device '{self.ctx.settings.device}' is away", "unreachable")
            return
        unknown = [servo for servo in message.ids if servo not in self._joints]
        if unknown:
            call.refuse(
                f"no joint has servo {unknown[0]}; there are {', '.join(map(str, self._joints))}", "unknown_name"
            )
            return
        jobs = {}
        for servo, out in session.targets.servos.items():
            asked = out.latched and servo in (message.ids or self._joints)
            job = session.link.recovery(servo) if asked else None
            if job is not None:
                jobs[servo] = session.thread.submit(job, WRITE)
        if not jobs:
            call.reply(CommandReply(accepted=True, reason="no servo has latched a fault"))
            return
        self._recovering.append((call, jobs))

    def answer(self, session: ServoSession[S, B]) -> None:
        """Reply to finished recoveries."""
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
                    session.targets.recovered(servo)
            if failed:
                call.refuse("; ".join(failed), "failed")
            else:
                said = self.named(list(jobs), "recovered, without torque:")
                call.reply(CommandReply(accepted=True, reason=said))
        self._recovering = waiting

    def refuse_waiting(self, reason: str) -> None:
        """Refuse the recoveries that wait for the line."""
        for call, _ in self._recovering:
            call.refuse(reason, "unreachable")
        self._recovering.clear()

    def unusable(self, session: ServoSession[S, B]) -> str:
        """Return a sentence about the servos that cannot be used, or an empty string."""
        snapshot = session.poller.snapshot
        away = [servo for servo, seen in snapshot.servos.items() if seen.reason]
        return self.named(away, "cannot be used:") if away else ""

    def state_key(self, session: ServoSession[S, B], now: float) -> tuple[object, ...]:
        """Return the values whose change is published at once."""
        gate = self._gate
        phase, rests = self.phase(session, now), session.rest.lasts
        return self._snapshot.sweep, phase, rests, gate.reason, self.ctx.estop.engaged, gate.halt

    def measured(self, session: ServoSession[S, B], now: float) -> Measured:
        """Return the readings of all servos, with their orders."""
        snapshot, model = self._snapshot, session.link.model
        targets = session.targets.servos.values()
        servos = tuple(servo_state(target, snapshot.servos[target.id], model, now) for target in targets)
        return Measured(snapshot.sweep, snapshot.ended, servos, statistics(session.bus, snapshot))

    def _heed_estop(self, session: ServoSession[S, B], now: float) -> None:
        """Acknowledge the stop once every servo was read to hold its position, or to be without torque."""
        estop = self.ctx.estop
        if not estop.engaged:
            if self._estopped:
                self._estopped = False
                estop.acknowledge(stopped=False, reason="released")
            return
        self._estopped = True
        released = self.ctx.settings.on_estop == "release"
        unconfirmed = session.targets.unconfirmed(self._snapshot, released=released)
        if unconfirmed and now - self._asked_at >= CONFIRM_S:
            self._asked_at = now
            session.thread.submit(lambda _bus: session.poller.look(unconfirmed), READ, key="confirm")
        known = self._snapshot.searched
        why = (
            self.named(unconfirmed, "not confirmed by")
            if unconfirmed
            else ""
            if known
            else "the servos are still being looked for"
        )
        estop.acknowledge(stopped=known and not unconfirmed, reason=why)
