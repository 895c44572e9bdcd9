"""A line of servos as a capability: setpoints in, coherent states out, and the final decision about torque."""

import queue
import sys
from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import inf
from typing import Any, Generic, NamedTuple, TypeVar

from lbr.capability.base import Capability
from lbr.capability.context import Context, Device
from lbr.drivers.guard import WOKEN
from lbr.drivers.servos import ServosSettings
from lbr.drivers.servos.gate import ServoGate, first, receive, strength, tick
from lbr.drivers.servos.rest import BELIEVED_S
from lbr.drivers.servos.session import Session
from lbr.errors import DeviceError
from lbr.messages.joints import Joint
from lbr.messages.servos import BusStatistics, ServoPhase, ServoSetpoint, ServosState, ServoState

SWITCH_S = 1e-4
"""The longest time for which the loop's thread may delay the bus's thread."""
PUBLISH_S = 0.1
RATE_HZ, REST_HZ = 100.0, 10.0
BEATS = 4
"""The number of beats, at rest, within the silence after which a guard kills its driver."""
NAMED = 3
LOST_S = 1.0
"""The time before the loss of a sender is reported. Chosen, not measured: ten times the life of a setpoint."""
S = TypeVar("S", bound=ServosSettings)


T = TypeVar("T", bound=Session[Any, Any])


class Measured(NamedTuple):
    """One coherent reading of all servos, as their state publishes it; `sweep` is 0 before the first."""

    sweep: int
    ended: float
    servos: tuple[ServoState, ...]
    bus: BusStatistics


class Servos(Capability[S], ABC, Generic[S, T]):
    """Applies fresh setpoints to the rows' servos; in every doubt they hold, and are then released slowly.

    The common behaviour of all drivers of servos. `RegisterServos` adds the rest for servos whose registers can be read
    back; a driver of others implements the abstract methods itself.
    """

    rate_hz = RATE_HZ
    warn_every_s = 0.0
    """The least time between two changes of a warning."""

    def __init__(self, ctx: Context[S]) -> None:
        super().__init__(ctx)
        self._joints = {joint.device_id: joint.name for joint in ctx.rows(Joint)}
        self._gate = first(ctx.clock())
        self._session: T | None = None
        self._events: queue.SimpleQueue[tuple[str, str, str]] = queue.SimpleQueue()
        self._left_on = self._lost = False
        self._published = self._warned_at = -inf
        self._published_key: tuple[object, ...] = ()
        self._warned: str | None = None

    @abstractmethod
    def connected(self, device: Device, servos: list[int]) -> T:
        """Open the line of a device row for these servos; switch nothing on, and move nothing."""

    @abstractmethod
    def act(self, session: T, now: float) -> None:
        """Send the servos their orders by `self._gate` and the emergency stop, and acknowledge that stop."""

    @abstractmethod
    def measured(self, session: T, now: float) -> Measured:
        """Return the known values of all servos."""

    @abstractmethod
    def state_key(self, session: T, now: float) -> tuple[object, ...]:
        """Return the values whose change is published at once."""

    @abstractmethod
    def unusable(self, session: T) -> str:
        """Return a sentence about the servos that cannot be used, or an empty string."""

    @abstractmethod
    def refuse_waiting(self, reason: str) -> None:
        """Refuse the commands that wait for the line."""

    def open(self) -> None:
        """Open the line and begin to search for the servos; switch nothing on, and move nothing."""
        settings = self.ctx.settings
        device = self.device_row
        if not self._joints:
            raise DeviceError(f"'{self.ctx.name}' has no servos: the table joint has no rows for this robot; add them")
        sys.setswitchinterval(SWITCH_S)
        self._gate, self._valid_s = first(self.ctx.clock()), settings.setpoint_valid_s
        self._session = self.connected(device, list(self._joints))
        self._warned, self._warned_at = None, -inf

    def step(self) -> None:
        """Decide, send orders to the servos, answer commands, and publish."""
        session = self._session
        assert session is not None
        self.hear(session)
        self._check_threads(session)
        self.check(session, self.ctx.clock())
        self._listen()
        now, estop = self.ctx.clock(), self.ctx.estop
        stopped = estop.reason if estop.engaged else None
        before = self._gate
        self._gate = tick(before, now, self._valid_s, self._without_sender(), stopped)
        if self._gate != before:
            session.rest.stir()
        self.act(session, now)
        session.beat()
        session.judge()
        self.answer(session)
        if self.known():
            self._tell_of_loss(session, now)
            self._report(session, now)
            self._publish_when_due(session, now)
        settings = self.ctx.settings
        resting_hz = max(REST_HZ, BEATS * 1000.0 / settings.guard_silence_ms)
        self.rate_hz = min(RATE_HZ, resting_hz) if session.rest.lasts else RATE_HZ

    def hear(self, session: T) -> None:
        """Process the line's reports about itself."""

    def check(self, session: T, now: float) -> None:
        """Raise the errors that end the session."""

    def answer(self, session: T) -> None:
        """Answer the commands whose transactions are done."""

    def answers(self) -> bool:
        """Return whether the line answers."""
        return self._session is not None and self._session.answers

    def known(self) -> bool:
        """Return whether the torque of every servo is known."""
        return True

    def admit(self, setpoint: ServoSetpoint, arrived: float, now: float) -> None:
        """Pass a setpoint of the wired source to the gate."""
        before, valid_s = self._gate, self.ctx.settings.setpoint_valid_s
        self._gate = receive(before, setpoint, arrived, now, valid_s)
        self.believe(before)

    def believe(self, before: ServoGate) -> None:
        """Extend the life of an admitted setpoint if it repeats `before` for servos at rest; else end their rest."""
        session, gate, valid_s = self._session, self._gate, self.ctx.settings.setpoint_valid_s
        if gate is before or session is None:
            return
        alike = (gate.goals, gate.wanted, gate.halt, gate.reason, gate.lost_since)
        if alike == (before.goals, before.wanted, before.halt, before.reason, before.lost_since):
            self._valid_s = max(valid_s, BELIEVED_S) if session.rest.lasts else valid_s
        else:
            self._valid_s = valid_s
            session.rest.stir()

    def degraded(self, reason: str) -> None:
        """Publish that the line is away."""
        if self.ctx.estop.engaged:
            self.ctx.estop.acknowledge(stopped=False, reason=reason)
        self.refuse_waiting(reason)
        self._publish(None, reason)

    def close(self) -> None:
        """Make the servos hold or release, by the row, and close the line; the guard keeps servos with torque."""
        session, self._session = self._session, None
        if session is not None:
            self._left_on = session.turning
            session.close(release=self.ctx.settings.on_close == "release")

    def named(self, servos: Sequence[int], what: str) -> str:
        """Return a few of the servos by joint and number."""
        some = ", ".join(f"{self._joints[servo]} (servo {servo})" for servo in servos[:NAMED])
        return f"{what} {some}" + (f" and {len(servos) - NAMED} more" if len(servos) > NAMED else "")

    def tell(self, kind: str, text: str, level: str) -> None:
        """Queue an event for the loop's thread; from any thread."""
        self._events.put((kind, text, level))

    def phase(self, session: T | None, now: float) -> ServoPhase:
        """Return the phase of the servos."""
        return "released" if session is None or not session.turning else self.energised_phase(now)

    def energised_phase(self, now: float) -> ServoPhase:
        """Return the phase of servos with torque."""
        if self._gate.follows:
            return "following"
        return "releasing" if self._strength(now) < 1.0 else "holding"

    def _check_threads(self, session: T) -> None:
        failure = session.failure
        if isinstance(failure, DeviceError):
            raise failure
        if failure is not None:
            raise RuntimeError(f"the servos' bus: {type(failure).__name__}: {failure}") from failure
        if session.guard is not None and not session.guard.standing:
            raise DeviceError(f"device '{self.ctx.settings.device}': its guard process died or hangs; reopening")
        if session.guard is not None and session.guard.woken():
            self.ctx.event("guard", WOKEN, level="warning")

    def _listen(self) -> None:
        sources = self.ctx.sources("setpoint")
        for received in self.ctx.take("setpoint"):
            if received.source in sources:
                self.admit(received.message, received.arrived, self.ctx.clock())

    def _without_sender(self) -> str:
        sources = self.ctx.sources("setpoint")
        if not sources:
            return "no source is wired to the setpoint"
        return "" if any(self.ctx.alive(source) for source in sources) else f"'{sources[0]}' is not on the bus"

    def _strength(self, now: float) -> float:
        return strength(self._gate, now, self.ctx.settings.hold_s, self.ctx.settings.release_s)

    def _tell_of_loss(self, session: T, now: float) -> None:
        """Publish that servos lost their sender, and later that they were released."""
        since, settings = self._gate.lost_since, self.ctx.settings
        if since is None:
            self._lost = False
        elif not self._lost and session.turning and now - since >= LOST_S + settings.setpoint_valid_s - self._valid_s:
            self._lost = True
            left = f"hold for {max(0.0, settings.hold_s + since - now):.0f} s and are then released"
            text = f"{self._gate.reason}: the servos {left}; a motion or /torque/on keeps them"
            self.ctx.event("mover_lost", text, level="warning", code=self._gate.code)
        elif self._lost and not session.turning:
            self._lost = False
            self.ctx.event("let_go", "the servos had no sender for too long: they have no torque now", level="warning")

    def _report(self, session: T, now: float) -> None:
        while not self._events.empty():
            kind, text, level = self._events.get()
            self.ctx.event(kind, text, level=level)
        wrong = self.unusable(session)
        usable = self.answers() and not self.lacks()
        if usable and wrong != self._warned and now - self._warned_at >= self.warn_every_s:
            self._warned, self._warned_at = wrong, now
            if wrong:
                self.ctx.warn(wrong, "unreachable")
            else:
                self.ctx.ready()

    def _publish_when_due(self, session: T, now: float) -> None:
        key = self.state_key(session, now)
        if key != self._published_key or now - self._published >= PUBLISH_S:
            before, self._published_key = self._published_key, key
            self._publish(session)
            self.published(session, before, now)

    def published(self, session: T, before: tuple[object, ...], now: float) -> None:
        """Publish what depends on a state; `before` is the last published key."""

    def _publish(self, session: T | None, away: str = "") -> None:
        """Publish one coherent reading of all servos, or that the line is away."""
        now = self._published = self.ctx.clock()
        if session is None:
            phase: ServoPhase = "holding" if self._left_on else "released"
            state = ServosState(
                sweep=0, measured_s=now, armed=False, phase=phase, servos=(), reason=away, **self.common_state()
            )
        else:
            measured, inhibited = self.measured(session, now), self.inhibited()
            state = ServosState(
                sweep=measured.sweep,
                measured_s=measured.ended if measured.sweep else now,
                armed=not inhibited,
                phase=self.phase(session, now),
                servos=measured.servos,
                reason=inhibited or self._gate.reason,
                code="" if inhibited else self._gate.code,
                rests=session.rest.lasts,
                bus=measured.bus,
                **self.common_state(),
            )
        self.ctx.publish("state", state)

    def inhibited(self) -> str:
        """Return why a setpoint would not be applied now, or an empty string."""
        absence = self._without_sender()
        return (self._gate.reason or absence) if self._gate.estop or absence else ""

    def common_state(self) -> dict[str, Any]:
        """Return the fields of a state that need no line."""
        device = self.ctx.device if self._session is not None else None
        heard = device.tap.heard if device is not None else None
        return {"estop": self.ctx.estop.engaged, "halt": self._gate.halt or 0, "heard": heard}
