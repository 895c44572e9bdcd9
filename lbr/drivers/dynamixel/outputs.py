"""What every servo is told: torque on and off, torque limits and goals, and whether it did as told, read back from it.

Lives in the loop's thread; what it wants on the wire it submits as jobs to the bus's owner.
"""

from collections.abc import Callable, Collection, Iterable
from concurrent.futures import Future
from math import inf
from typing import Protocol, TypeVar

from lbr.drivers.dynamixel import table
from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.dynamixel.output import Output, confirms, switching
from lbr.drivers.dynamixel.packet import error_names
from lbr.drivers.dynamixel.setup import Kept
from lbr.drivers.dynamixel.sweep import Seen, Snapshot
from lbr.drivers.dynamixel.table import Motion
from lbr.drivers.mover import Mover
from lbr.drivers.owner import STOP, WRITE
from lbr.messages.servos import ServoGoal

MEASURED_S = 0.25
"""A position older than this is not where the servo is, and a servo that was not heard for so long is told no goals."""
FRESH_S = 0.05
"""Nor is this old where a servo is that moves: to be held there would take it back."""
FOUND_S = 0.5
"""So long a servo that was found with torque keeps it until who moves them knows of it."""
REPEAT_S = 0.1
AGAIN_S = 0.2
FADE_STEP = 10
"""Of 1023: a smaller change of the torque limit is not worth a packet."""
LET_GO = "was let go; switch its torque off, then on"
T = TypeVar("T")


class Submits(Protocol):
    """The bus's owner, as far as it is needed here."""

    def submit(self, job: Callable[[Bus], T], priority: int, key: object = None) -> "Future[T]":
        """Have a job done."""


class Outputs:
    """All servos of a bus. Whatever it does is told to the servos on the next occasion, stops first."""

    def __init__(
        self,
        servos: Collection[int],
        owner: Submits,
        clock: Callable[[], float],
        kept: Callable[[int], Kept | None],
        told: Callable[[str, str, str], None] = lambda _kind, _text, _level: None,
    ) -> None:
        self.servos = {servo: Output(servo) for servo in servos}
        self._owner = owner
        self._clock = clock
        self._kept = kept
        self._told = told
        self._halts = 0
        self._followed = False
        self._sending: Future[None] | None = None
        self._sent_at = -inf
        self._faded_at = -inf

    def apply(self, mover: Mover, strength: float, snapshot: Snapshot) -> None:
        """Do what follows from the mover's state and from what the servos said last."""
        found = [out for out in self._all() if self._read_back(out, snapshot.servos[out.id], mover)]
        found += [out for out in self._all() if out.adrift and self._motion(out, snapshot, FRESH_S)]
        self._unblock(mover)
        self._let_go(mover, strength)
        halted = mover.halts != self._halts or (self._followed and not mover.follows)
        self._halts, self._followed = mover.halts, mover.follows
        self._freeze([out for out in self._all() if out.on] if halted else found, snapshot)
        self._limit(mover, strength)
        if mover.follows:
            self._switch_on(mover, snapshot)
            self._follow(mover, snapshot)

    def release(self, why: str) -> None:
        """Take the torque off every servo that may have it, at once."""
        self._off([out for out in self._all() if out.on or out.switching or not out.known], why)

    def hold(self, snapshot: Snapshot) -> None:
        """Have every servo hold where it was measured."""
        self._freeze([out for out in self._all() if out.on], snapshot)

    @property
    def turning(self) -> bool:
        """Whether any servo has torque, or is getting it."""
        return any(out.on or out.switching for out in self.servos.values())

    def unconfirmed(self, snapshot: Snapshot, *, released: bool) -> list[int]:
        """Return the servos that have not yet been read to hold their goal, or to be without torque if `released`."""
        asked = [out for out in self._all() if out.known and (released or out.on)]
        return [out.id for out in asked if not confirms(out, snapshot.servos[out.id], released=released)]

    def recovered(self, servo: int) -> None:
        """Note that a latched servo was taken out of its fault; it has no torque before somebody switches it on anew."""
        out = self.servos[servo]
        out.latched, out.settled = (), self._clock()
        out.blocked = "was recovered; switch its torque off, then on"

    def _all(self) -> Iterable[Output]:
        return self.servos.values()

    def _read_back(self, out: Output, seen: Seen, mover: Mover) -> bool:
        """Compare with what the servo says; True if it was found with torque that nobody here gave it."""
        self._switched(out)
        slow = seen.slow
        if slow is None or slow.at <= out.settled or out.switching is not None:
            return False
        if not out.known:
            out.known, out.on, out.goal, out.speed = True, slow.enabled, slow.goal, slow.speed
            out.limit = out.full = slow.limit
            out.found = self._clock()
            if slow.limit == 0:
                self._latch(out, seen)
            motion = seen.motion if self._clock() - seen.at < FRESH_S else None
            out.stays = motion is not None and table.holding_goal(motion.position, motion.speed, slow.goal) == slow.goal
            return out.on and not out.stays
        if slow.limit == 0 and not out.latched:
            self._latch(out, seen)
        elif slow.enabled and not out.on:
            self._off([out], "")
        elif out.on and not slow.enabled:
            out.on, out.adrift, out.blocked = (
                False,
                False,
                "lost its torque: was it without power? Switch it off, then on",
            )
            self._told("torque_lost", f"servo {out.id} {out.blocked}", "error")
        elif out.on and not mover.follows and slow.at > out.aimed and out.goal not in {None, slow.goal}:
            self._write(table.GOAL_POSITION.address, {out.id: table.GOAL_POSITION.encode(out.goal)}, STOP)
        return False

    def _latch(self, out: Output, seen: Seen) -> None:
        kept = self._kept(out.id)
        out.latched = error_names(seen.error & (kept.shutdown if kept else 0x7F)) or ("shutdown",)
        out.blocked = f"has latched {', '.join(out.latched)}; remove the cause, then recover it"
        self._told("servo_latched", f"servo {out.id} {out.blocked}", "error")
        self._off([out], out.blocked)

    def _unblock(self, mover: Mover) -> None:
        if mover.seen:
            for out in self._all():
                if out.id not in mover.wanted and not out.latched:
                    out.blocked = ""

    def _let_go(self, mover: Mover, strength: float) -> None:
        if not strength > 0.0:
            self._off([out for out in self._all() if out.on or out.switching], LET_GO)
        elif mover.seen:
            turning = [out for out in self._all() if out.on or out.switching]
            late = self._clock() - FOUND_S
            self._off([out for out in turning if out.id not in mover.wanted and out.found < late], "")

    def _off(self, outs: list[Output], why: str) -> None:
        for out in outs:
            if out.switching is not None:
                out.switching.cancel()
                out.switching = None
            out.on = out.stays = out.adrift = False
            out.blocked = out.blocked or why
        if outs:
            self._forget_goals()
            self._write(table.TORQUE_ENABLE.address, {out.id: b"\0" for out in outs}, STOP)

    def _forget_goals(self) -> None:
        """What still waits to be sent must not come after a stop."""
        if self._sending is not None and self._sending.cancel():
            for out in self._all():
                out.aimed = min(out.aimed, self._clock())
        self._sending, self._sent_at = None, -inf

    def _freeze(self, outs: list[Output], snapshot: Snapshot) -> None:
        """Have servos hold where they are; one that was not measured just now keeps the goal it has heard until it is."""
        if outs:
            self._forget_goals()
        goals = {}
        for out in (out for out in outs if out.on):
            motion = self._motion(out, snapshot, FRESH_S)
            out.stays, out.adrift, out.goal = False, True, None
            if motion is not None:
                out.stays, out.adrift, out.goal = True, False, motion.position
                goals[out.id] = table.GOAL_POSITION.encode(motion.position)
        self._write(table.GOAL_POSITION.address, goals, STOP)

    def _motion(self, out: Output, snapshot: Snapshot, within_s: float) -> Motion | None:
        """Return what was measured of a servo, if that is not too old."""
        seen = snapshot.servos[out.id]
        return seen.motion if self._clock() - seen.at < within_s else None

    def _limit(self, mover: Mover, strength: float) -> None:
        now = self._clock()
        limits = {}
        for out in self._all():
            if not out.on:
                continue
            if mover.follows and (goal := mover.goals.get(out.id)) is not None:
                out.full = self._full(out, goal)
            faded = max(1, round(out.full * strength))
            if (mover.follows and faded != out.limit) or (strength < 1.0 and out.limit - faded >= FADE_STEP):
                limits[out.id] = faded
        if limits and (mover.follows or now - self._faded_at >= REPEAT_S / 2.0):
            self._faded_at = now
            for servo, limit in limits.items():
                self.servos[servo].limit = limit
            blocks = {servo: table.TORQUE_LIMIT.encode(limit) for servo, limit in limits.items()}
            self._write(table.TORQUE_LIMIT.address, blocks, WRITE)

    def _full(self, out: Output, goal: ServoGoal) -> int:
        kept = self._kept(out.id)
        return min(table.torque_raw(goal.torque), kept.max_torque if kept else table.FULL_TORQUE) or 1

    def _switch_on(self, mover: Mover, snapshot: Snapshot) -> None:
        now = self._clock()
        for out in self._all():
            if out.on or out.switching is not None or out.id not in mover.wanted or out.again > now:
                continue
            seen = snapshot.servos[out.id]
            if out.known and not out.blocked and not out.latched and seen.motion is not None and not seen.reason:
                goal = mover.goals[out.id]
                out.full = out.limit = self._full(out, goal)
                out.speed = table.speed_raw(goal.speed_rps)
                out.settled = inf
                job = switching(out.id, out.speed, out.limit)
                out.switching = self._owner.submit(job, WRITE)

    def _switched(self, out: Output) -> None:
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

    def _follow(self, mover: Mover, snapshot: Snapshot) -> None:
        changed = False
        for out in self._all():
            goal = mover.goals.get(out.id)
            if not out.on or goal is None:
                continue
            before = (out.goal, out.speed)
            out.speed = table.speed_raw(goal.speed_rps)
            if goal.position_rad is not None:
                out.goal, out.stays, out.adrift = table.position_raw(goal.position_rad), False, False
            elif not (out.stays or out.adrift):
                self._freeze([out], snapshot)
            changed = changed or before != (out.goal, out.speed)
        now = self._clock()
        if changed or now - self._sent_at >= REPEAT_S:
            self._sent_at = now
            goals = {
                out.id: table.GOAL_POSITION.encode(out.goal) + table.MOVING_SPEED.encode(out.speed)
                for out in self._all()
                if out.on and out.goal is not None and self._motion(out, snapshot, MEASURED_S)
            }
            self._sending = self._write(table.GOAL_POSITION.address, goals, WRITE, key="goals")

    def _write(
        self, address: int, blocks: dict[int, bytes], priority: int, key: object = None
    ) -> "Future[None] | None":
        if not blocks:
            return None
        outs = [self.servos[servo] for servo in blocks]
        goals = address == table.GOAL_POSITION.address

        def note(when: float) -> None:
            for out in outs:
                if goals:
                    out.aimed = when
                else:
                    out.settled = when

        def job(bus: Bus) -> None:
            bus.write_all(address, blocks)
            note(self._clock())

        note(inf)
        return self._owner.submit(job, priority, key)
