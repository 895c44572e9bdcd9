"""The orders for every servo, torque, torque limits and goals, and their effect as read back.

It lives in the loop's thread, and submits its writes as jobs to the bus's thread.
"""

from collections.abc import Callable, Collection, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from math import inf
from typing import Generic, TypeVar

from lbr.drivers.servos.bus_thread import STOP, WRITE, BusThread
from lbr.drivers.servos.contract import B, Motion, Seen, ServoBus, ServoModel, Snapshot, Tell
from lbr.drivers.servos.gate import ServoGate
from lbr.drivers.servos.rest import FULL_S, Rest
from lbr.drivers.servos.torque import Target, Torque
from lbr.messages.servos import ServoGoal

R = TypeVar("R")
MEASURED_S = 0.25
"""The age limit of a position; a servo without an answer for this long gets no goals."""
FRESH_S = 0.05
"""The age limit of a moving servo's position: a hold there would pull it back. A few sweeps; chosen, not measured."""
REPEAT_S = 0.1
AGAIN_S = 0.2
FADE_STEP = 0.0097
"""The least change of the torque limit, as a share of full torque, that is worth a packet."""


@dataclass(slots=True)
class TargetState(Target):
    """The wanted and the sent order for one servo. `settled`: the time of its last order about torque, inf while that
    waits. `aimed`: the time of its last goal. `stays`: its goal is its measured position."""

    goal: int | None = None
    speed: int = 0
    limit: int = 0
    full: int = 0
    settled: float = -inf
    aimed: float = -inf
    latched: tuple[str, ...] = ()
    stays: bool = False
    switching: "Future[int | str] | None" = None
    again: float = -inf

    @property
    def energised(self) -> bool:
        """Return whether it has torque, or is getting it."""
        return self.on or self.switching is not None

    def unblock(self) -> None:
        """Allow torque again, unless it has latched a fault."""
        if not self.latched:
            self.blocked = ""


class ServoTargets(Torque[TargetState], Generic[B]):
    """All servos of a bus. Its orders are sent at the next opportunity, stops first."""

    def __init__(
        self,
        servos: Collection[int],
        thread: BusThread[B],
        clock: Callable[[], float],
        model: ServoModel,
        tell: Tell = lambda _kind, _text, _level: None,
        rest: Rest | None = None,
    ) -> None:
        super().__init__(servos, lambda servo: TargetState(servo, full=model.full_torque), clock)
        self._thread = thread
        self._model = model
        self._tell = tell
        self._rest = rest or Rest(clock)
        self._sending: Future[None] | None = None
        self._sent_at = -inf
        self._faded_at = -inf
        self.broken: Exception | None = None
        """The error of a job apart from the line: an order was not sent to a servo."""

    def apply(self, gate: ServoGate, strength: float, snapshot: Snapshot) -> None:
        """Send the orders that follow from the gate's state and the last readings."""
        unplaced = [target for target in self._all() if self._read_back(target, snapshot.servos[target.id], gate)]
        unplaced += [target for target in self._all() if target.adrift and self._motion(target, snapshot, FRESH_S)]
        stopped = self.advance(gate, strength)
        self._freeze([target for target in self._all() if target.on] if stopped else unplaced, snapshot)
        self._limit(gate, strength)
        if gate.follows:
            if self.guarded:
                self._switch_on(gate, snapshot)
            self._follow(gate, snapshot)

    def release(self, why: str) -> None:
        """Switch off, at once, every servo that may have torque."""
        self.off([target for target in self._all() if target.energised or not target.known], why)

    def hold(self, snapshot: Snapshot) -> None:
        """Make every servo hold its measured position."""
        self._freeze([target for target in self._all() if target.on], snapshot)

    def off(self, targets: Sequence[TargetState], why: str) -> None:
        """Switch the torque of these servos off at the same time, before all else."""
        for target in targets:
            if target.switching is not None:
                target.switching.cancel()
                target.switching = None
            target.on = target.stays = target.adrift = False
            target.blocked = target.blocked or why
        if targets:
            self._forget_goals()
            servos = tuple(target.id for target in targets)
            self._submit(servos, lambda bus: bus.torque_off(servos), STOP)

    def unconfirmed(self, snapshot: Snapshot, *, released: bool) -> list[int]:
        """Return the servos without a reading that they hold their goal, or, if `released`, have no torque."""
        asked = [target for target in self._all() if target.known and (released or target.energised)]
        return [target.id for target in asked if not _confirms(target, snapshot.servos[target.id], released=released)]

    def recovered(self, servo: int) -> None:
        """Note that a servo was recovered from its fault; it stays without torque until that is switched on again."""
        target = self.servos[servo]
        target.latched, target.settled = (), self._clock()
        target.blocked = "was recovered; switch its torque off, then on"

    def _read_back(self, target: TargetState, seen: Seen, gate: ServoGate) -> bool:
        """Update the target by the servo's report; return True if it has torque that was not switched on here."""
        self._switched(target)
        slow = seen.slow
        if slow is None or slow.at <= target.settled or target.switching is not None:
            return False
        if not target.known:
            target.known, target.on, target.goal, target.speed = True, slow.enabled, slow.goal, slow.speed
            target.limit = target.full = slow.limit
            target.found_at = self._clock()
            self._latch(target, seen)
            motion = seen.motion if self._clock() - seen.at < FRESH_S else None
            target.stays = (
                motion is not None and self._model.holding_goal(motion.position, motion.speed, slow.goal) == slow.goal
            )
            return target.on and not target.stays
        if not target.latched and self._latch(target, seen):
            return False
        if slow.enabled and not target.on:
            self.off([target], "")
        elif target.on and not slow.enabled:
            target.on = target.adrift = False
            target.blocked = "lost its torque: was it without power? Switch it off, then on"
            self._tell("torque_lost", f"servo {target.id} {target.blocked}", "error")
        elif target.on and not gate.follows and slow.at > target.aimed and target.goal not in {None, slow.goal}:
            self._place({target.id: target.goal})
        return False

    def _latch(self, target: TargetState, seen: Seen) -> bool:
        """Switch the torque off a servo that has latched a fault; return whether it has."""
        target.latched = self._model.latched(target.id, seen)
        if not target.latched:
            return False
        target.blocked = f"has latched {', '.join(target.latched)}; remove the cause, then recover it"
        self._tell("servo_latched", f"servo {target.id} {target.blocked}", "error")
        self.off([target], target.blocked)
        return True

    def _forget_goals(self) -> None:
        """Cancel the waiting goals: they must not follow a stop."""
        if self._sending is not None and self._sending.cancel():
            for target in self._all():
                target.aimed = min(target.aimed, self._clock())
        self._sending, self._sent_at = None, -inf

    def _freeze(self, targets: list[TargetState], snapshot: Snapshot) -> None:
        """Make servos hold their position; a servo without a fresh reading keeps its last goal until there is one."""
        if targets:
            self._forget_goals()
        goals = {}
        for target in (target for target in targets if target.on):
            motion = self._motion(target, snapshot, FRESH_S)
            target.stays, target.adrift, target.goal = False, True, None
            if motion is not None:
                target.stays, target.adrift, target.goal = True, False, motion.position
                goals[target.id] = motion.position
        self._place(goals)

    def _motion(self, target: TargetState, snapshot: Snapshot, within_s: float) -> Motion | None:
        """Return the motion of a servo, if it is fresh enough."""
        seen = snapshot.servos[target.id]
        return seen.motion if self._clock() - seen.at < within_s else None

    def _limit(self, gate: ServoGate, strength: float) -> None:
        now = self._clock()
        limits = {}
        for target in self._all():
            if not target.on:
                continue
            if gate.follows and (goal := gate.goals.get(target.id)) is not None:
                target.full = self._full(target, goal)
            faded = max(1, round(target.full * strength))
            if (gate.follows and faded != target.limit) or (
                strength < 1.0 and target.limit - faded >= self._model.full_torque * FADE_STEP
            ):
                limits[target.id] = faded
        if limits and (gate.follows or now - self._faded_at >= REPEAT_S / 2.0):
            self._faded_at = now
            for servo, limit in limits.items():
                self.servos[servo].limit = limit
            self._queue(lambda bus: bus.write_limits(limits), WRITE)

    def _full(self, target: TargetState, goal: ServoGoal) -> int:
        return min(self._model.torque_raw(goal.torque), self._model.most_torque(target.id)) or 1

    def _switch_on(self, gate: ServoGate, snapshot: Snapshot) -> None:
        now = self._clock()
        for target in self._all():
            if target.on or target.switching is not None or target.id not in gate.wanted or target.again > now:
                continue
            seen = snapshot.servos[target.id]
            usable = target.known and not target.blocked and not target.latched
            if usable and seen.motion is not None and not seen.reason:
                goal = gate.goals[target.id]
                target.full = target.limit = self._full(target, goal)
                target.speed = self._model.speed_raw(goal.speed_rps)
                target.settled = inf
                target.switching = self._queue(_switching(target.id, target.speed, target.limit), WRITE)

    def _switched(self, target: TargetState) -> None:
        """Process the result of switching a servo on."""
        future = target.switching
        if future is None or not future.done():
            return
        target.switching, target.settled = None, self._clock()
        if future.cancelled() or future.exception() is not None:
            return
        result = future.result()
        if isinstance(result, int):
            target.on, target.goal, target.trouble = True, result, ""
            target.stays, target.adrift = True, False
            target.aimed = target.settled
            return
        if target.trouble != result:
            self._tell("torque_refused", f"servo {target.id} gets no torque: it {result}", "warning")
        target.trouble, target.again = result, self._clock() + AGAIN_S

    def _follow(self, gate: ServoGate, snapshot: Snapshot) -> None:
        changed = False
        for target in self._all():
            goal = gate.goals.get(target.id)
            if not target.on or goal is None:
                continue
            before = (target.goal, target.speed)
            target.speed = self._model.speed_raw(goal.speed_rps)
            if goal.position_rad is not None:
                target.goal, target.stays, target.adrift = self._model.position_raw(goal.position_rad), False, False
            elif not (target.stays or target.adrift):
                self._freeze([target], snapshot)
            changed = changed or before != (target.goal, target.speed)
        now = self._clock()
        if changed:
            self._rest.stir()
        if changed or now - self._sent_at >= (FULL_S if self._rest.lasts else REPEAT_S):
            self._sent_at = now
            goals = {
                target.id: (target.goal, target.speed)
                for target in self._all()
                if target.on and target.goal is not None and self._motion(target, snapshot, MEASURED_S)
            }
            self._sending = self._submit(
                goals, lambda bus: bus.write_goals(goals), WRITE, goals=True, key="goals", stirs=False
            )

    def _place(self, goals: dict[int, int]) -> None:
        self._submit(goals, lambda bus: bus.write_positions(goals), STOP, goals=True)

    def _submit(
        self,
        servos: Collection[int],
        write: Callable[[B], None],
        priority: int,
        *,
        goals: bool = False,
        key: object = None,
        stirs: bool = True,
    ) -> "Future[None] | None":
        """Submit a write for servos, and note when it was on the wire: goals, or else torque."""
        if not servos:
            return None
        targets = [self.servos[servo] for servo in servos]

        def note(when: float) -> None:
            for target in targets:
                if goals:
                    target.aimed = when
                else:
                    target.settled = when

        def job(bus: B) -> None:
            write(bus)
            note(self._clock())

        note(inf)
        return self._queue(job, priority, key, stirs=stirs)

    def _queue(self, job: Callable[[B], R], priority: int, key: object = None, *, stirs: bool = True) -> "Future[R]":
        if stirs:
            self._rest.stir()

        def watched(bus: B) -> R:
            try:
                return job(bus)
            except Exception as err:
                if not isinstance(err, OSError):
                    self.broken = err
                raise

        return self._thread.submit(watched, priority, key)


def _switching(servo: int, speed: int, limit: int) -> "Callable[[ServoBus], int | str]":
    return lambda bus: bus.torque_on(servo, speed, limit)


def _confirms(target: TargetState, seen: Seen, *, released: bool) -> bool:
    """Return whether a reading since the last order confirms that it holds its goal, or has no torque if `released`."""
    slow = seen.slow
    if slow is None or slow.at <= max(target.settled, target.aimed) or seen.reason or target.switching is not None:
        return False
    return not slow.enabled if released else target.goal == slow.goal
