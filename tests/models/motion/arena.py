"""The drive kernel and the model of it side by side: everything that happens goes to both, and they must agree."""

import hashlib
from collections import deque
from collections.abc import Callable
from math import inf, isfinite, isnan, nan

from lbr.leases.lease import EstopChanged, Happened, Reply, Setpoint, Stop
from lbr.messages.attitude import AttitudeState
from lbr.messages.codes import MEANINGS
from lbr.messages.drive import GoalResult
from lbr.messages.leases import CommandReply
from lbr.messages.motors import MotorSetpoint, MotorsState
from lbr.messages.odometry import OdometryState
from lbr.operations.drive import kernel
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import (
    AttitudeSeen,
    Event,
    MotorsLost,
    MotorsSeen,
    OdometrySeen,
    Outputs,
    RangesSeen,
    State,
    Tick,
)
from tests.models.motion.message import Message, command_event, to_ranges
from tests.models.motion.reference import (
    ACCEL_PER_S,
    CHECKS_S,
    LATE_S,
    MAX_POWER,
    MAX_RUN_S,
    STUCK_S,
    TTL_S,
    TURN_POWER,
    TURN_SPARE_S,
    TURN_TOLERANCE_DEG,
    WAY_TOLERANCE_M,
    Lease,
    Reference,
)
from tests.models.motion.senses import FULL_DPS, FULL_MPS, Body
from tests.models.motion.surroundings import MEMORY_S

Decide = Callable[[State, Event, float], tuple[State, Outputs]]
SETTINGS = DriveSettings(
    max_power=MAX_POWER,
    accel_per_s=ACCEL_PER_S,
    max_run_s=MAX_RUN_S,
    ttl_s=TTL_S,
    blocked_s=3600.0,
    max_speed_mps=FULL_MPS,
    max_turn_dps=FULL_DPS,
    turn_power=TURN_POWER,
    turn_spare_s=TURN_SPARE_S,
    turn_stuck_s=STUCK_S,
    turn_tolerance_deg=TURN_TOLERANCE_DEG,
    distance_tolerance_m=WAY_TOLERANCE_M,
    memory_s=MEMORY_S,
)
ARMED = MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False)
DISARMED = MotorsState(left=0.0, right=0.0, armed=False, reason="tripped", estop=False)
SLACK = 1e-9
EVENTS_KEPT = 40
DELAYS_KEPT = 256
HASH_EVERY = 2048
STUCK_TICKS = 10
LONGEST_STEP_S = 0.1
TICK = Tick()


class ViolationError(AssertionError):
    """The kernel did what must never be."""


class Arena:
    """Time, a kernel, its model, and what must always hold between them."""

    def __init__(self, decide: Decide = kernel.decide, start: float = 100.0) -> None:
        self.now = start
        self.steps = 0
        self.counts: dict[str, int] = {}
        self._recent: deque[tuple[int, float, str, object]] = deque(maxlen=EVENTS_KEPT)
        self.model = Reference()
        self.state = kernel.first_state(SETTINGS)
        self._decide = decide
        self._digest = hashlib.blake2b(digest_size=16)
        self._trace: list[object] = []
        self._wheels = (0.0, 0.0)
        self._wheels_at = nan
        self._names = 0
        self._idle_ticks = 0
        self._delays: dict[tuple[str, str], float] = {}
        self._goals: set[str] = set()
        self._held_goal = self._kind = ""
        self._undecided = False
        self.body = Body()
        self._told_holder = ""

    @property
    def trace(self) -> str:
        """Return the hash of everything that happened so far."""
        self._flush()
        return self._digest.hexdigest()

    def recent(self) -> list[str]:
        """Return the last events in words, oldest first."""
        return [
            f"{step:>9} {now:12.4f} {kind:12} {'' if what is None else what}" for step, now, kind, what in self._recent
        ]

    @property
    def holder(self) -> str:
        """Return the lease that holds the base, or nothing."""
        return self.model.hold.name if self.model.hold else ""

    # what happens

    def tick(self) -> None:
        """Time for the next setpoint."""
        self.model.advance(self.now)
        self._do(TICK, "tick")
        if self._wheels_at != self.now and self.now == self.now:
            raise self._violation("a tick brought no setpoint")
        self._moves_when_free()

    def stop(self, source: str, sent: float | None = None) -> None:
        """Somebody stops it."""
        sent = self.now if sent is None else sent
        self.model.advance(self.now)
        self.model.stop(source, sent, self.now)
        reply = self._do(Stop(source=source, received=sent), "stop", source)
        if reply is None or not reply.accepted or self._wheels != (0.0, 0.0):
            raise self._violation("a stop was not obeyed")

    def latch(self, engaged: bool) -> None:
        """The emergency stop is pressed or reset."""
        self.model.advance(self.now)
        self.model.latch(engaged, self.now)
        self._do(EstopChanged(engaged=engaged, reason="button"), "latch", engaged)
        if self._wheels != (0.0, 0.0):
            raise self._violation("the emergency stop, or its reset, left it moving")

    def motors(self, *, armed: bool = True, at: float | None = None) -> None:
        """The motor driver speaks."""
        at = self.now if at is None else at
        self.model.advance(self.now)
        self.model.motors(armed, at, self.now)
        self._do(MotorsSeen(motors=ARMED if armed else DISARMED, arrived=at), "motors", armed)

    def motors_lost(self) -> None:
        """The motor driver is gone."""
        self.model.advance(self.now)
        self.model.motors_lost(self.now)
        self._do(MotorsLost(reason="motors is gone"), "lost")

    def ranges(self, distances: dict[str, float], *, at: float | None = None, twice: bool = True) -> None:
        """Distances come, infinite for nothing near and NaN for no reading; `twice`: the second one confirms them."""
        at = self.now if at is None else at
        self.model.advance(self.now)
        self._came_to_rest()
        event = RangesSeen(ranges=to_ranges(distances), arrived=at)
        self.model.ranges(distances, at, self.now, twice=twice)
        self._do(event, "ranges", distances)
        if twice:
            self._do(event, "ranges again")

    def attitude(self, *, at: float | None = None, **changes: object) -> None:
        """The attitude speaks; `changes` are what it tells otherwise than it is."""
        at, told = self.now if at is None else at, self.body.attitude() | changes
        self.model.advance(self.now)
        self._came_to_rest()
        self.model.feel(self.model.attitude, told, at, self.now)
        attitude = AttitudeState(
            valid=told["valid"],  # type: ignore[arg-type]
            epoch=told["epoch"],  # type: ignore[arg-type]
            measured_s=at,
            turned_deg=told["value"],  # type: ignore[arg-type]
            heading_deg=told["heading"],  # type: ignore[arg-type]
        )
        self._do(AttitudeSeen(attitude=attitude, arrived=self.now), "attitude", told)

    def odometry(self, *, at: float | None = None, **changes: object) -> None:
        """The odometry speaks."""
        at, told = self.now if at is None else at, self.body.odometry() | changes
        self.model.advance(self.now)
        self._came_to_rest()
        self.model.feel(self.model.odometry, told, at, self.now)
        odometry = OdometryState(
            valid=told["valid"],  # type: ignore[arg-type]
            epoch=told["epoch"],  # type: ignore[arg-type]
            counted_s=at,
            distance_m=told["value"],  # type: ignore[arg-type]
            speed_mps=told["speed"],  # type: ignore[arg-type]
            stalled=told["stalled"],  # type: ignore[arg-type]
        )
        self._do(OdometrySeen(odometry=odometry, arrived=self.now), "odometry", told)

    def command(self, message: Message) -> CommandReply:
        """A command arrives; return the reply."""
        self._names += 1
        name, model, now = f"L{self._names}", self.model, self.now
        model.advance(now)
        expected = model.command(message, now, now, name, message.check is not None)
        self._undecided = expected is None
        reply = self._do(command_event(message, name, now), "command", message)
        self._undecided = False
        if reply is None:
            raise self._violation("a command was not answered")
        if expected is None:
            model.settle(message, now, now, name, reply.accepted)
        elif reply.accepted != expected:
            raise self._violation(f"the model {'accepts' if expected else 'refuses'} it, the kernel says {reply}")
        if reply.accepted:
            self._was_accepted(message, reply, name)
        self._agrees()
        return reply

    # what must hold

    def _do(self, event: Event, kind: str, what: object = None) -> CommandReply | None:
        self.steps += 1
        self._kind = kind
        self.counts[kind] = self.counts.get(kind, 0) + 1
        self._recent.append((self.steps, self.now, kind, what))
        self._trace += (self.now, kind)
        self.state, outputs = self._decide(self.state, event, self.now)
        reply = None
        for output in outputs:
            if isinstance(output, Setpoint):
                self._setpoint(output.message)
            elif isinstance(output, Reply):
                reply = output.message
                self._trace.append(reply.reason)
                if not reply.accepted and reply.code not in MEANINGS:
                    raise self._violation(f"a refusal without a code of the list: {reply}")
            elif isinstance(output, Happened):
                self._happened(output)
            else:
                self._ended(output.message)
        if kind != "command":
            self._agrees()
        if len(self._trace) > HASH_EVERY:
            self._flush()
        return reply

    def _setpoint(self, setpoint: MotorSetpoint) -> None:
        left, right = setpoint.left, setpoint.right
        was_left, was_right = self._wheels
        elapsed_s = self._count_way()
        if left or right:
            self._trace += (left, right)
            if not (isfinite(left) and isfinite(right) and abs(left) <= MAX_POWER and abs(right) <= MAX_POWER):
                raise self._violation(f"a setpoint beyond all bounds: {left} {right}")
            most = ACCEL_PER_S * elapsed_s + SLACK
            if not (abs(left) <= abs(was_left) + most and abs(right) <= abs(was_right) + most):
                raise self._violation(f"faster growth than allowed: {self._wheels} to {left} {right}")
            if left * was_left < 0.0 or right * was_right < 0.0:
                raise self._violation(f"the sense changed without a zero: {self._wheels} to {left} {right}")
            if setpoint.motors or self.state.aside:
                raise self._violation(f"two wheels were told more than left and right: {setpoint}")
            if not setpoint.lease:
                raise self._violation("it moves under no lease")
            if why := self.model.around.too_fast(left, right, self.now) or self._off_target(left, right):
                raise self._violation(why)
        self._wheels = left, right

    def _off_target(self, left: float, right: float) -> str:
        """Return what is wrong with wheels that turn to a target or drive to an end, or nothing."""
        hold = self.model.hold
        if hold is None or self._undecided:
            return ""
        if hold.message.turns:
            left_deg = self.model.left(hold)
            if max(abs(left), abs(right)) > TURN_POWER + SLACK:
                return f"a turn with more power than is allowed: {left} {right}"
            if left * left_deg < 0.0 or right * left_deg > 0.0:
                return f"it turns the wrong way with {left_deg} degrees to go: {left} {right}"
        elif hold.message.moves and hold.message.distance_cm > 0.0 and self._is_at_end(hold):
            return f"it drives on at the end of its way: {left} {right}"
        return ""

    def _is_at_end(self, hold: Lease) -> bool:
        return self.model.left(hold) * hold.asked <= 0.0

    def _came_to_rest(self) -> None:
        """What just ended, ended before what is heard now counts."""
        if self.model.hold is None and self._wheels != (0.0, 0.0):
            self._count_way()

    def _count_way(self) -> float:
        """Count how far the base came since the wheels were told something; return how long that was."""
        elapsed_s = min(max(0.0, self.now - self._wheels_at), LONGEST_STEP_S)
        self._wheels_at = self.now
        if self._wheels != (0.0, 0.0):
            self.model.around.drove(*self._wheels, elapsed_s)
        self.body.drove(*self._wheels, elapsed_s)
        return elapsed_s

    def _happened(self, event: Happened) -> None:
        self._trace.append(event.text)
        if event.kind == "holder":
            self._told_holder = event.data.get("took", "")

    def _ended(self, result: GoalResult) -> None:
        if result.code not in MEANINGS:
            raise self._violation(f"a result without a code of the list: {result}")
        if result.goal not in self._goals:
            raise self._violation(f"the result of {result.goal}, which does not run")
        self._goals.remove(result.goal)
        felt = self._kind in {"attitude", "odometry"} and result.result in {"reached", "fault"}
        if (
            (felt or (result.result == "reached" and self.model.nears_a_range))
            and self.model.hold is not None
            and result.goal == self._held_goal
        ):
            standing = self._wheels == (0.0, 0.0)
            if why := self.model.ended(result.result, result.code, standing):
                raise self._violation(why)

    def _agrees(self) -> None:
        """Compare what the kernel and the model think of who holds the base, and what that means for the wheels."""
        hold, held = self.state.lease, self.model.hold
        if (hold.id if hold else "") != (held.name if held else ""):
            raise self._violation(f"the kernel is held by {hold}, the model by {held and (held.name, held.message)}")
        left, right = self._wheels
        if left or right:
            if held is None or self.model.estop:
                raise self._violation("it moves although nobody may move it")
            if not held.message.moves:
                raise self._violation("it moves although the holder wants it still")
            if (left, right) != (self.state.left, self.state.right):
                raise self._violation("the motors were told something else than the kernel thinks")
        if self._goals and self._goals != self._running():
            raise self._violation(f"goals that neither run nor ended: {self._goals} and {self._running()}")
        if self.state.leases.tally.untold == 0 and self._told_holder != (hold.source if hold else ""):
            raise self._violation(f"the record says that '{self._told_holder}' holds it")

    def _running(self) -> set[str]:
        known = (self.state.lease, *self.state.leases.offers)
        return {hold.motion.goal.goal for hold in known if hold is not None and hold.motion.goal is not None}

    def _moves_when_free(self) -> None:
        held = self.model.hold
        wants = (
            held is not None
            and held.message.power > 0.0
            and not held.message.distance_cm
            and self.model.around.free(held.message.angle_deg, self.now)
        )
        self._idle_ticks = self._idle_ticks + 1 if wants and self._wheels == (0.0, 0.0) else 0
        if self._idle_ticks > STUCK_TICKS:
            raise self._violation("it does not move although it may")

    def _was_accepted(self, message: Message, reply: CommandReply, name: str) -> None:
        if not message.moves and not message.lease:
            return
        if reply.lease != (message.lease or name):
            raise self._violation(f"a lease that is neither new nor the quoted one: {reply}")
        if message.remote and not message.lease and reply.lease == self.holder:
            raise self._violation("a motion from afar began without proof")
        if reply.goal:
            self._goals.add(reply.goal)
        if reply.lease == self.holder:
            self._held_goal = reply.goal
        if message.moves and not isnan(message.ahead_s):
            self._was_fresh(message, reply.lease)

    def _was_fresh(self, message: Message, lease: str) -> None:
        """Hold an accepted command's true age against what its receiver could know of it."""
        age_s = self.now - message.sent
        allowed_s = LATE_S + (CHECKS_S if message.check is not None else 0.0)
        if message.remote:
            quickest_s = min(age_s, self._delays.get((lease, message.source), inf))
            if len(self._delays) > DELAYS_KEPT:
                self._delays.clear()
            self._delays[lease, message.source] = quickest_s
            allowed_s += quickest_s
        if age_s > allowed_s + SLACK:
            raise self._violation(f"a command {age_s:.3f} s old was acted on")

    def _flush(self) -> None:
        self._digest.update(repr(self._trace).encode())
        self._trace.clear()

    def _violation(self, what: str) -> ViolationError:
        return ViolationError(f"step {self.steps}: {what}")
