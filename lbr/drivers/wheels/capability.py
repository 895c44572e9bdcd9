"""A motor driver as a capability: setpoints in, power at the wheels, and the final decision whether they turn."""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from math import inf, nan
from typing import Any, TypeVar

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context, Device, Received
from lbr.drivers.guard import WOKEN
from lbr.drivers.wheels import EnableCommand, WheelsSettings
from lbr.drivers.wheels.arming import Arming, Inhibit, Setpoint, receive, tick
from lbr.drivers.wheels.contract import EMERGENCY_STOP, Measured, WheelController
from lbr.drivers.wheels.guard import Guard
from lbr.errors import DeviceError
from lbr.messages.codes import Reason
from lbr.messages.kinematics import TWO, Kinematics, Wheel, base_of
from lbr.messages.leases import CommandReply
from lbr.messages.motors import MotorsState, MotorState

RATE_HZ, STANDING_HZ = 50.0, 20.0
RESTING_SHARE = 0.5
"""The period of rounds of armed motors at rest, as a share of the controller's watchdog, which each round feeds."""
PUBLISH_PERIOD_S = 0.05
RESTING_PERIOD_S, RESTS_AFTER_S, BEGINS_S = 0.45, 0.5, 2.0
"""The period of the state of armed motors at rest. It begins late enough for readers that start beside them."""
STANDING_PERIOD_S = 0.09
"""The period of the state while the wheels stand: a third of the age at which the drive calls it too old."""
RESEND_S = 0.015
SOON = 0.75
"""The share of a round after which its regular work is due; a setpoint may wake it in between."""
REPORT_PERIOD_S = 5.0
FEW = 8
"""The number of unanswered commands that is reported first, then each doubling: a few are harmless."""
ARMS_S = 0.3
"""The wait of a request to switch the motors on until they are armed: a fault or the emergency stop may prevent it."""
GUARD_STARTS = "its guard process is starting"
UNASKED = (
    "the controller's emergency stop is engaged, but not by this robot: "
    "release it at the controller, or engage and reset the emergency stop"
)


S = TypeVar("S", bound=WheelsSettings)


class Wheels(Capability[S], ABC):
    """Applies fresh setpoints to the wheels; in every doubt writes zero and waits for a neutral one.

    A driver adds `connect`. Setpoints, arming, the emergency stop, the guard and the telemetry are the same for all.
    """

    rate_hz = RATE_HZ
    motors: Sequence[str] = TWO
    """The names of its motors, as in rows of `wheel` and in setpoints, in the controller's order."""

    def __init__(self, ctx: Context[S]) -> None:
        super().__init__(ctx)
        self._controller: WheelController | None = None
        self._guard: Guard | None = None
        self._arming = Arming(count=len(self.motors), since=ctx.clock())
        self._rest = (0.0,) * len(self.motors)
        self._base = base_of(ctx.rows(Kinematics), ctx.rows(Wheel), track_m=1.0)
        self._enabled = ctx.settings.enabled
        self._latched = False  # an emergency stop was requested and is not released yet
        self._source = ""
        self._switching: deque[tuple[Call, float]] = deque()
        self._queried = -inf
        self._published_key: tuple[object, ...] = ()
        self._published_readings: Measured = {}
        self._reported = -inf
        self._watchdog_s = ctx.settings.watchdog_ms / 1000.0

    @abstractmethod
    def connect(self, device: Device, beat: Callable[[], None]) -> WheelController:
        """Open the line of a device row and return its controller, whose `open` is called next."""

    def open(self) -> None:
        """Open the line and start the controller, at zero."""
        settings = self.ctx.settings
        self._controller = self.connect(self.device_row, self._beat)
        self._controller.open()
        if settings.guard:
            self._guard = self._guarded(self._controller)
        self._held_since: float | None = None  # the time at which the controller acknowledged the emergency stop
        self._stepped: float | None = None
        self._faults: tuple[str, ...] = ()
        self._lacks: Reason | None = None
        self._unanswered = 0
        self._moved_at = self.ctx.clock() + BEGINS_S
        self._publish()
        self._published_key = ()

    def step(self) -> None:
        """Decide, write the wheels once, send the controller one query, and publish."""
        controller = self._controller
        assert controller is not None
        if self._guard is not None and not self._guard.standing:
            raise DeviceError(f"device '{self.ctx.settings.device}': its guard process died or hangs; reopening")
        self._beat()
        if self._guard is not None and self._guard.woken():
            self.ctx.event("guard", WOKEN, level="warning")
        self._heed_estop(controller)
        self._decide(controller)
        self._act(controller)
        self._ask(controller)
        self._report(controller)
        self._tell_what_lacks()
        self._publish_when_due(controller)
        self._answer_switching()
        self.rate_hz = RATE_HZ if self._arming.moving or not controller.resting else 1.0 / self._standing_s

    def command(self, call: Call) -> None:
        """Switch execution on or off; the reply to on waits for a zero setpoint, so that the next motion is obeyed."""
        if not isinstance(call.message, EnableCommand):
            super().command(call)
            return
        self._enabled = call.message.enabled  # the step that follows at once applies it
        if self._enabled:
            self._switching.append((call, self.ctx.clock() + ARMS_S))
        else:
            call.reply(CommandReply(accepted=True, reason="the motors are held at zero until 'enable'"))

    def degraded(self, reason: str) -> None:
        """Publish that the controller is away."""
        if self.ctx.estop.engaged:
            self._latched = True
            self.ctx.estop.acknowledge(stopped=False, reason=reason)
        self._disarm(reason)
        self._publish()
        self._answer_switching(waits=False)

    def close(self) -> None:
        """Write zero, then close the line; without an acknowledgement the guard writes it again."""
        controller, self._controller = self._controller, None
        guard, self._guard = self._guard, None
        stopped = False
        try:
            stopped = controller is None or controller.close()
        finally:
            if guard is not None and stopped:
                guard.dismiss()
            elif guard is not None:
                guard.speak()
            self._disarm("the line was closed")
            self._answer_switching(waits=False)

    def _answer_switching(self, *, waits: bool = True) -> None:
        while self._switching:
            call, until = self._switching[0]
            if waits and not self._arming.armed and self.ctx.clock() < until:
                return
            self._switching.popleft()
            call.reply(CommandReply(accepted=True, reason="the motors may run again"))

    def _guarded(self, controller: WheelController) -> Guard:
        settings = self.ctx.settings
        try:
            return Guard(controller.fileno(), controller.guard_stop, settings.guard_silence_ms, self.ctx.clock)
        except OSError as err:
            said = f"device '{settings.device}': its guard process does not start: {err}; free some memory"
            raise DeviceError(said) from err

    def _beat(self) -> None:
        if self._guard is not None and self._controller is not None:
            self._guard.beat(turning=self._controller.turning)

    def _heed_estop(self, controller: WheelController) -> None:
        estop = self.ctx.estop
        if estop.engaged:
            self._latched = True
            if self._held_since is not None:
                faults = controller.faults_after(self._held_since)
                if faults is not None and EMERGENCY_STOP not in faults:
                    self._held_since = None  # reset, or released elsewhere
            if self._held_since is None and controller.emergency_stop():
                self._held_since = self.ctx.clock()
            held = self._held_since is not None
            estop.acknowledge(stopped=held, reason="" if held else "the controller has not acknowledged")
        elif self._latched and controller.release():
            self._latched = False
            self._held_since = None
            estop.acknowledge(stopped=False, reason="released")

    def _decide(self, controller: WheelController) -> None:
        before, valid_s = self._arming, self.ctx.settings.setpoint_valid_s
        state = before
        for received in self.ctx.take("setpoint"):
            if received.source in self.ctx.sources("setpoint"):
                self._source = received.source
                state = receive(state, self._setpoint(received), self.ctx.clock(), valid_s)
        now = self.ctx.clock()
        self._arming = tick(state, self._inhibit(controller, now), now, valid_s)
        self._stepped = now
        self._tell_trip(before)

    def _setpoint(self, received: Received) -> Setpoint:
        """Return the power of each motor; a motor missing in the message gets NaN, unless all are zero."""
        message, born = received.message, received.arrived
        begun = nan if message.moving_s is None else born - message.moving_s
        powers_by_motor = message.motors or {"left": message.left, "right": message.right}
        if not message.motors and message.left == message.right == 0.0:
            return Setpoint(self._rest, message.lease, born, begun=begun)
        powers = tuple(powers_by_motor.get(motor, nan) for motor in self.motors)
        unnamed = next((motor for motor in self.motors if motor not in powers_by_motor), "")
        return Setpoint(powers, message.lease, born, unnamed, begun)

    def _inhibit(self, controller: WheelController, now: float) -> Inhibit | None:
        if self.ctx.estop.engaged:
            return Inhibit(f"emergency stop: {self.ctx.estop.reason or 'no reason given'}", fault=False)
        if self._latched:
            return Inhibit("emergency stop: the controller has not acknowledged the release", fault=False)
        if not self._enabled:
            return Inhibit("execution is disabled", fault=False)
        if self._guard is not None and not self._guard.listens:
            return Inhibit(GUARD_STARTS, fault=False)
        return self._without_source() or self._with_fault(controller) or self._held_up(controller, now)

    def _without_source(self) -> Inhibit | None:
        sources = self.ctx.sources("setpoint")
        if not sources:
            return Inhibit("no source is wired to the setpoint", fault=False)
        source = self._source or sources[0]
        return None if self.ctx.alive(source) else Inhibit(f"'{source}' is not on the bus", fault=True)

    def _with_fault(self, controller: WheelController) -> Inhibit | None:
        faults = controller.faults
        if faults is None:
            return Inhibit("the controller's fault bits are not known", fault=True)
        if EMERGENCY_STOP in faults:
            return Inhibit(UNASKED, fault=True)
        grave = controller.grave
        return Inhibit(_fault_sentence(grave), fault=True) if grave else None

    def _held_up(self, controller: WheelController, now: float) -> Inhibit | None:
        """Return an inhibit after a pause, of the driver or the controller, that is longer than a setpoint lives.

        The next motion must then begin with zero, because it may be far up its ramp. At rest the rounds are further
        apart; the gate checks the dates of their setpoints.
        """
        valid_s = self.ctx.settings.setpoint_valid_s
        most_s = valid_s + (self._standing_s if self._arming.rests else 0.0)
        if self._stepped is not None and not now - self._stepped < most_s:
            return Inhibit(f"the driver was held up for {now - self._stepped:.2f} s", fault=True)
        if self._arming.moving and not controller.fed_s_ago < valid_s:
            return Inhibit(f"the controller has taken no command for {controller.fed_s_ago:.2f} s", fault=True)
        return None

    @property
    def _standing_s(self) -> float:
        """Return the period of its rounds while nothing moves."""
        return RESTING_SHARE * self._watchdog_s if self._arming.rests else 1.0 / STANDING_HZ

    def _act(self, controller: WheelController) -> None:
        state, held = self._arming, self._held_since is not None
        standing_s = SOON * self._standing_s if state.rests else self._watchdog_s / 2
        hungry = not controller.fed_s_ago < (RESEND_S if state.moving else standing_s)
        if not state.moving and not controller.resting and not held:
            controller.stop()
        elif state.armed:
            if state.applied != controller.asked or hungry:
                controller.drive(*state.applied)
        elif not held and hungry:
            controller.stop()  # fed with zero, the controller does not accept another source of commands

    def _ask(self, controller: WheelController) -> None:
        now = self.ctx.clock()
        if now - self._queried < (RESEND_S if self._arming.moving else SOON * self._standing_s):
            return
        self._queried = now
        controller.poll()

    def _report(self, controller: WheelController) -> None:
        faults = controller.faults
        if faults is not None and faults != self._faults and not self._latched:
            self._tell_faults(faults)
        unanswered = controller.lost + controller.refused
        if unanswered >= max(FEW, 2 * self._unanswered) and self.ctx.clock() - self._reported > REPORT_PERIOD_S:
            self._unanswered, self._reported = unanswered, self.ctx.clock()
            data = {"lost": controller.lost, "refused": controller.refused}
            counted = f"{controller.lost} commands unanswered and refused {controller.refused}"
            text = f"the controller has left {counted} since it was opened"
            self.ctx.event("unanswered", text, level="warning", data=data)

    def _tell_faults(self, faults: tuple[str, ...]) -> None:
        self._faults = faults
        if faults:
            self.ctx.event("fault", _fault_sentence(faults), level="error", data={"faults": list(faults)})
        else:
            self.ctx.event("fault", "the controller reports no fault any more")

    def _tell_what_lacks(self) -> None:
        """Publish whether it is ready: not with a fault, nor before its guard listens, as no wheel turns until then."""
        lacks = None
        if self._faults:
            lacks = Reason("latched", _fault_sentence(self._faults))
        elif self._guard is not None and not self._guard.listens:
            lacks = Reason("not_ready", GUARD_STARTS)
        if lacks != self._lacks:
            self._lacks = lacks
            if lacks:
                self.ctx.warn(lacks)
            else:
                self.ctx.ready()

    def _tell_trip(self, before: Arming) -> None:
        if self._arming.trips > before.trips:
            gate, data = self._arming, {"trips": self._arming.trips}
            self.ctx.event("trip", f"motors stopped: {gate.reason}", level="warning", data=data, code=gate.code)

    def _disarm(self, reason: str) -> None:
        before = self._arming
        self._arming = tick(before, Inhibit(reason, fault=True), self.ctx.clock(), self.ctx.settings.setpoint_valid_s)
        self._tell_trip(before)

    def _publish_when_due(self, controller: WheelController) -> None:
        key = (
            self._arming.armed,
            self._arming.reason,
            self._arming.trips,
            self.ctx.estop.engaged,
            controller.faults,
            self._arming.moving,
            controller.applied == self._rest,
        )
        period_s = RESTING_PERIOD_S if self._rests else STANDING_PERIOD_S if self._stands else PUBLISH_PERIOD_S
        if self._rests and not self._near(controller.measured(), self._published_readings):
            period_s = 0.0
        if key != self._published_key or not self.ctx.clock() - self._published < period_s:
            self._published_key = key
            self._publish()

    def _near(self, measured: Measured, before: Measured) -> bool:
        """Return whether no motor has turned by more than a flicker."""
        counts, others = _counts(measured), _counts(before)
        band = self.ctx.settings.still_counts
        same = all(
            one == other or (one is not None and other is not None and abs(one - other) <= band)
            for one, other in zip(counts, others, strict=False)
        )
        return same and len(counts) == len(others)

    def _publish(self) -> None:
        self._published = self.ctx.clock()
        state = self._arming
        if self._controller is None:
            self.ctx.publish("state", _at_rest(state, estop=self.ctx.estop.engaged))
            return
        before, self._published_readings = self._published_readings, self._controller.measured()
        self._stands = not state.moving and self._near(self._published_readings, before)
        self._moved_at = self._moved_at if self._stands and state.rests else max(self._moved_at, self._published)
        self._rests = self._published - self._moved_at >= RESTS_AFTER_S
        message = MotorsState(
            **self._each(self._controller.applied, self._published_readings),
            armed=state.armed,
            reason=state.reason,
            code=state.code,
            estop=self.ctx.estop.engaged,
            trips=state.trips,
            heard=self.device_row.tap.heard,
            rests=self._rests,
        )
        self.ctx.publish("state", message)

    def _each(self, applied: Sequence[float], readings: Measured) -> dict[str, Any]:
        """Return applied and measured values: of `left` and `right` in their fields, of other motors by name."""
        unknown = (None,) * len(applied)
        amps, counts = readings.get("motor_amps_a", unknown), readings.get("motor_counts", unknown)
        measured = {name: value for name, value in readings.items() if not name.startswith("motor_")}
        if tuple(self.motors) == TWO:
            return {"left": applied[0], "right": applied[1], **measured}
        each = zip(self.motors, applied, amps, counts, strict=True)
        motors = {name: MotorState(power=power, amps_a=a, counts=n) for name, power, a, n in each}
        left, right = self._sides({name: motor.power for name, motor in motors.items()})
        return {"left": left, "right": right, "motors": motors, **measured}

    def _sides(self, applied: dict[str, float]) -> tuple[float, float]:
        """Return the powers of the two sides of the base, by its rows; zero if the rows name other motors."""
        base = self._base
        if not applied.keys() >= set(base.motors):
            return 0.0, 0.0
        left, right, _ = base.sides([applied[motor] for motor in base.motors])
        return left, right


def _counts(measured: Measured) -> tuple[int | None, ...]:
    return measured.get("counts_left"), measured.get("counts_right"), *measured.get("motor_counts", ())


def _fault_sentence(faults: Sequence[str]) -> str:
    return UNASKED if EMERGENCY_STOP in faults else f"the controller reports {', '.join(faults)}"


def _at_rest(state: Arming, *, estop: bool) -> MotorsState:
    return MotorsState(left=0.0, right=0.0, armed=False, reason=state.reason, estop=estop, trips=state.trips)
