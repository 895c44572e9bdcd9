"""The orders for every servo: torque on and off, torque limits and goals, and their effect, read back from it.

Lives in the loop's thread; what it wants on the wire it submits as jobs to the bus's thread.
"""

from collections.abc import Callable, Collection, Iterable
from concurrent.futures import Future
from dataclasses import dataclass
from math import inf
from typing import Generic, TypeVar

from lbr.drivers.servos.bus_thread import STOP, WRITE, BusThread
from lbr.drivers.servos.contract import B, Motion, Seen, ServoBus, ServoModel, Snapshot, Tell
from lbr.drivers.servos.gate import ServoGate
from lbr.drivers.servos.rest import FULL_S, Rest
from lbr.messages.servos import ServoGoal

R = TypeVar("R")
MEASURED_S = 0.25
"""A position older than this is not where the servo is, and a servo that was not heard for this long is told no goals.
"""
FRESH_S = 0.05
"""Of a moving servo even this age is too old: to be held there would take it back. A few sweeps; chosen, not measured.
"""
FOUND_S = 0.5
"""The time that a servo that was found with torque keeps it until its mover knows of it: a few rounds of state and
setpoint, so that a servo heard late after a restart keeps its torque. Chosen, not measured."""
REPEAT_S = 0.1
AGAIN_S = 0.2
FADE_STEP = 0.0097
"""A smaller share of the full torque is not worth a packet."""
LET_GO = "was released; switch its torque off, then on"


@dataclass(slots=True)
class TargetState:
    """The wanted and the sent order for one servo. `settled`: the time of its last order about torque; inf while that
    waits; `aimed`: its goal.

    `blocked` says why it gets no torque before a setpoint had it without. `stays`: its goal is where it was measured;
    `adrift`: it is to be held where it is as soon as that is measured; `found`: when it was first heard, with torque.
    """

    id: int
    known: bool = False
    on: bool = False
    goal: int | None = None
    speed: int = 0
    limit: int = 0
    full: int = 0
    settled: float = -inf
    aimed: float = -inf
    blocked: str = ""
    trouble: str = ""
    latched: tuple[str, ...] = ()
    stays: bool = False
    adrift: bool = False
    found: float = -inf
    switching: "Future[int | str] | None" = None
    again: float = -inf


class ServoTargets(Generic[B]):
    """All servos of a bus. Its orders go to the servos on the next occasion, stops first."""

    def __init__(
        self,
        servos: Collection[int],
        thread: BusThread[B],
        clock: Callable[[], float],
        model: ServoModel,
        told: Tell = lambda _kind, _text, _level: None,
        rest: Rest | None = None,
    ) -> None:
        self.servos = {servo: TargetState(servo, full=model.full_torque) for servo in servos}
        self._thread = thread
        self._clock = clock
        self._model = model
        self._told = told
        self._rest = rest or Rest(clock)
        self._halts = 0
        self._followed = False
        self._sending: Future[None] | None = None
        self._sent_at = -inf
        self._faded_at = -inf
        self.guarded = True
        """True if a guard would release the servos after this driver's death; before, no servo gets torque."""
        self.broken: Exception | None = None
        """The error of a job that does not concern the line: a servo was not told what it should be."""

    def apply(self, gate: ServoGate, strength: float, snapshot: Snapshot) -> None:
        """Do what follows from the gate's state and from what the servos said last."""
        found = [out for out in self._all() if self._read_back(out, snapshot.servos[out.id], gate)]
        found += [out for out in self._all() if out.adrift and self._motion(out, snapshot, FRESH_S)]
        self._unblock(gate)
        self._release(gate, strength)
        halted = gate.halts != self._halts or (self._followed and not gate.follows)
        self._halts, self._followed = gate.halts, gate.follows
        self._freeze([out for out in self._all() if out.on] if halted else found, snapshot)
        self._limit(gate, strength)
        if gate.follows:
            if self.guarded:
                self._switch_on(gate, snapshot)
            self._follow(gate, snapshot)

    def release(self, why: str) -> None:
        """Take the torque off every servo that may have it, at once."""
        self._off([out for out in self._all() if out.on or out.switching or not out.known], why)

    def hold(self, snapshot: Snapshot) -> None:
        """Have every servo hold where it was measured."""
        self._freeze([out for out in self._all() if out.on], snapshot)

    @property
    def turning(self) -> bool:
        """Return whether any servo has torque, or is getting it."""
        return any(out.on or out.switching for out in self.servos.values())

    def unconfirmed(self, snapshot: Snapshot, *, released: bool) -> list[int]:
        """Return the servos that have not yet been read to hold their goal, or to be without torque if `released`."""
        asked = [out for out in self._all() if out.known and (released or out.on or out.switching)]
        return [out.id for out in asked if not _confirms(out, snapshot.servos[out.id], released=released)]

    def recovered(self, servo: int) -> None:
        """Note that a latched servo was taken out of its fault; it has no torque before that is switched on again."""
        out = self.servos[servo]
        out.latched, out.settled = (), self._clock()
        out.blocked = "was recovered; switch its torque off, then on"

    def _all(self) -> Iterable[TargetState]:
        return self.servos.values()

    def _read_back(self, out: TargetState, seen: Seen, gate: ServoGate) -> bool:
        """Compare with what the servo says; True if it was found with torque that it was not given here."""
        self._switched(out)
        slow = seen.slow
        if slow is None or slow.at <= out.settled or out.switching is not None:
            return False
        if not out.known:
            out.known, out.on, out.goal, out.speed = True, slow.enabled, slow.goal, slow.speed
            out.limit = out.full = slow.limit
            out.found = self._clock()
            self._latch(out, seen)
            motion = seen.motion if self._clock() - seen.at < FRESH_S else None
            out.stays = (
                motion is not None and self._model.holding_goal(motion.position, motion.speed, slow.goal) == slow.goal
            )
            return out.on and not out.stays
        if not out.latched and self._latch(out, seen):
            return False
        if slow.enabled and not out.on:
            self._off([out], "")
        elif out.on and not slow.enabled:
            out.on, out.adrift, out.blocked = (
                False,
                False,
                "lost its torque: was it without power? Switch it off, then on",
            )
            self._told("torque_lost", f"servo {out.id} {out.blocked}", "error")
        elif out.on and not gate.follows and slow.at > out.aimed and out.goal not in {None, slow.goal}:
            self._place({out.id: out.goal})
        return False

    def _latch(self, out: TargetState, seen: Seen) -> bool:
        """Take the torque off a servo that has latched a fault; say whether it has."""
        out.latched = self._model.latched(out.id, seen)
        if not out.latched:
            return False
        out.blocked = f"has latched {', '.join(out.latched)}; remove the cause, then recover it"
        self._told("servo_latched", f"servo {out.id} {out.blocked}", "error")
        self._off([out], out.blocked)
        return True

    def _unblock(self, gate: ServoGate) -> None:
        if gate.seen:
            for out in self._all():
                if out.id not in gate.wanted and not out.latched:
                    out.blocked = ""

    def _release(self, gate: ServoGate, strength: float) -> None:
        if not strength > 0.0:
            self._off([out for out in self._all() if out.on or out.switching], LET_GO)
        elif gate.seen:
            turning = [out for out in self._all() if out.on or out.switching]
            late = self._clock() - FOUND_S
            self._off([out for out in turning if out.id not in gate.wanted and out.found < late], "")

    def _off(self, outs: list[TargetState], why: str) -> None:
        for out in outs:
            if out.switching is not None:
                out.switching.cancel()
                out.switching = None
            out.on = out.stays = out.adrift = False
            out.blocked = out.blocked or why
        if outs:
            self._forget_goals()
            servos = tuple(out.id for out in outs)
            self._submit(servos, lambda bus: bus.torque_off(servos), STOP)

    def _forget_goals(self) -> None:
        """Drop what still waits to be sent: it must not come after a stop."""
        if self._sending is not None and self._sending.cancel():
            for out in self._all():
                out.aimed = min(out.aimed, self._clock())
        self._sending, self._sent_at = None, -inf

    def _freeze(self, outs: list[TargetState], snapshot: Snapshot) -> None:
        """Have servos hold where they are; one that was not measured just now keeps the goal it has heard until it
        is."""
        if outs:
            self._forget_goals()
        goals = {}
        for out in (out for out in outs if out.on):
            motion = self._motion(out, snapshot, FRESH_S)
            out.stays, out.adrift, out.goal = False, True, None
            if motion is not None:
                out.stays, out.adrift, out.goal = True, False, motion.position
                goals[out.id] = motion.position
        self._place(goals)

    def _motion(self, out: TargetState, snapshot: Snapshot, within_s: float) -> Motion | None:
        """Return what was measured of a servo, if that is not too old."""
        seen = snapshot.servos[out.id]
        return seen.motion if self._clock() - seen.at < within_s else None

    def _limit(self, gate: ServoGate, strength: float) -> None:
        now = self._clock()
        limits = {}
        for out in self._all():
            if not out.on:
                continue
            if gate.follows and (goal := gate.goals.get(out.id)) is not None:
                out.full = self._full(out, goal)
            faded = max(1, round(out.full * strength))
            if (gate.follows and faded != out.limit) or (
                strength < 1.0 and out.limit - faded >= self._model.full_torque * FADE_STEP
            ):
                limits[out.id] = faded
        if limits and (gate.follows or now - self._faded_at >= REPEAT_S / 2.0):
            self._faded_at = now
            for servo, limit in limits.items():
                self.servos[servo].limit = limit
            self._queue(lambda bus: bus.write_limits(limits), WRITE)

    def _full(self, out: TargetState, goal: ServoGoal) -> int:
        return min(self._model.torque_raw(goal.torque), self._model.most_torque(out.id)) or 1

    def _switch_on(self, gate: ServoGate, snapshot: Snapshot) -> None:
        now = self._clock()
        for out in self._all():
            if out.on or out.switching is not None or out.id not in gate.wanted or out.again > now:
                continue
            seen = snapshot.servos[out.id]
            if out.known and not out.blocked and not out.latched and seen.motion is not None and not seen.reason:
                goal = gate.goals[out.id]
                out.full = out.limit = self._full(out, goal)
                out.speed = self._model.speed_raw(goal.speed_rps)
                out.settled = inf
                out.switching = self._queue(_switching(out.id, out.speed, out.limit), WRITE)

    def _switched(self, out: TargetState) -> None:
        """See what became of switching a servo on."""
        future = out.switching
        if future is None or not future.done():
            return
        out.switching, out.settled = None, self._clock()
        if future.cancelled() or future.exception() is not None:
            return
        result = future.result()
        if isinstance(result, int):
            out.on, out.goal, out.trouble = True, result, ""
            out.stays, out.adrift = True, False
            out.aimed = out.settled
            return
        if out.trouble != result:
            self._told("torque_refused", f"servo {out.id} gets no torque: it {result}", "warning")
        out.trouble, out.again = result, self._clock() + AGAIN_S

    def _follow(self, gate: ServoGate, snapshot: Snapshot) -> None:
        changed = False
        for out in self._all():
            goal = gate.goals.get(out.id)
            if not out.on or goal is None:
                continue
            before = (out.goal, out.speed)
            out.speed = self._model.speed_raw(goal.speed_rps)
            if goal.position_rad is not None:
                out.goal, out.stays, out.adrift = self._model.position_raw(goal.position_rad), False, False
            elif not (out.stays or out.adrift):
                self._freeze([out], snapshot)
            changed = changed or before != (out.goal, out.speed)
        now = self._clock()
        if changed:
            self._rest.stir()
        if changed or now - self._sent_at >= (FULL_S if self._rest.lasts else REPEAT_S):
            self._sent_at = now
            goals = {
                out.id: (out.goal, out.speed)
                for out in self._all()
                if out.on and out.goal is not None and self._motion(out, snapshot, MEASURED_S)
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
        """Have servos told their goals, or else their torque, and note when that was on the wire."""
        if not servos:
            return None
        outs = [self.servos[servo] for servo in servos]

        def note(when: float) -> None:
            for out in outs:
                if goals:
                    out.aimed = when
                else:
                    out.settled = when

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


def _confirms(out: TargetState, seen: Seen, *, released: bool) -> bool:
    """Return whether a servo was read, since it was told, to hold its goal; or to be without torque if `released`."""
    slow = seen.slow
    if slow is None or slow.at <= max(out.settled, out.aimed) or seen.reason or out.switching is not None:
        return False
    return not slow.enabled if released else out.goal == slow.goal
