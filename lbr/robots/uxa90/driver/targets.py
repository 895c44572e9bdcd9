"""The orders for every servo, as packets; all that changed leave in one write. Lives in the loop's thread.

Only `flush` and `brake` run in the line's thread: they write what is wanted at that moment.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from math import inf

from lbr.drivers.servos.gate import ServoGate
from lbr.messages.servos import ServoGoal
from lbr.robots.uxa90.driver import packets
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.packets import PACKET_BYTES, WEAKEST
from lbr.robots.uxa90.driver.plausibility import Seen
from lbr.robots.uxa90.driver.target_state import BRAKED, LET_GO, LIMP, TargetState

PLACE_S = 0.6
"""A position older than this is not where the servo is: twelve sweeps of the usual 20 a second. Chosen, not measured.
"""
WEAK_S = 2.0
"""The time that a servo goes at the weakest level if its place was unknown, or it was far from its goal. Chosen, not
measured."""
SAG = 8
"""The distance from its goal at which a servo may rest under its load, in counts. Chosen, not measured on a real robot.
"""
REST_S = 0.3
AGAIN_S = 1.0
MOVING_S = 1.0
OFF_AGAIN_S, OFF_TIMES = 0.1, 3
"""A released servo reports nothing of it, so it is told several times."""
STILL, STILL_S = 2, 0.04
"""Counts within which a servo stands still, for this long."""
FEW = 8
"""After a write to more servos than this the line needs a moment for itself."""
PLAYED_S = 1.0
"""The time after a motion of the main board in which servos get no goal before their places are read."""


class ServoTargets:
    """All servos of the line."""

    def __init__(
        self,
        servos: Collection[int],
        seen: Mapping[int, Seen],
        clock: Callable[[], float],
        wire_s: Callable[[int], float],
        offsets: Mapping[int, int] | None = None,
        blocked: str = "",
    ) -> None:
        self.servos = {servo: TargetState(servo, blocked=blocked) for servo in servos}
        self.open = False
        """True if servos can take orders now."""
        self._seen = seen
        self._clock = clock
        self._wire_s = wire_s
        self._offsets = offsets or {}
        self._halts = 0
        self._followed = False
        self._first_lease: str | None = None
        self._free_at = self._played_at = -inf
        self._applied_at = clock()

    @property
    def turning(self) -> bool:
        """Return whether any servo has torque by this driver, or may have had it by the one before."""
        return any(out.on or out.carried for out in self._all())

    @property
    def unknown(self) -> bool:
        """Return whether it is unknown of any servo if it has torque."""
        return any(not out.known for out in self._all())

    @property
    def due(self) -> bool:
        """Return whether there is something to write."""
        return self.open and any(out.want != out.said for out in self._all())

    def apply(self, gate: ServoGate, strength: float) -> None:
        """Do what follows from the gate's state and from where the servos are."""
        now = self._clock()
        self._unblock(gate)
        self._release(gate, strength)
        if gate.halts != self._halts or (self._followed and not gate.follows):
            self.freeze()
        self._halts, self._followed = gate.halts, gate.follows
        for out in self._all():
            self._settle(out, now)
        if gate.follows:
            self._follow(gate, now)
        if strength < 1.0:
            self._fade(strength)
        self._repeat(now)
        self._applied_at = now

    def freeze(self) -> None:
        """Have servos hold: their last goal, a step away from where they are, and when they rest, what they rest at."""
        now = self._clock()
        for out in self._all():
            if not out.on:
                continue
            here = self.place(out.id)
            if out.count is None:
                out.adrift = True
            elif now < out.weak_until and here is None:
                self._off(out, "was stopped on its way from an unknown place; switch its torque off, then on")
            else:
                if here is not None and now < out.weak_until:
                    out.count = here
                out.rest_at = now + REST_S
                out.said = None
                self._aim(out, out.level)

    def release(self, why: str) -> None:
        """Take the torque off every servo."""
        for out in self._all():
            self._off(out, why)

    def played(self, *, limp: bool) -> None:
        """The main board has moved all servos: they have torque, and their goals are not known here; or have none."""
        self._played_at = self._clock()
        for out in self._all():
            out.known, out.on, out.carried, out.adrift = True, not limp, False, False
            out.count = out.want = out.said = None
            out.level, out.rest_at, out.weak_until, out.led = 0, inf, -inf, None
            out.blocked = LIMP if limp else ""

    def loose(self, goals: Mapping[int, ServoGoal]) -> None:
        """Hold every servo that has torque where it is, as soon as that is read again; `goals` of now mean nothing
        more."""
        self._played_at = self._clock()
        for out in self._all():
            if out.on:
                out.count, out.want, out.said = None, None, None
                out.overtaken = goals[out.id].position_rad if out.id in goals else None
                out.adrift = True

    def brake(self, bus: Bus) -> None:
        """Short all motors; in the line's thread. One servo answers for all."""
        bus.say(packets.BREAK_ALL, 1)

    def braked(self) -> None:
        """Take in that they are to be."""
        for out in self._all():
            out.known, out.on, out.carried, out.adrift = True, False, False, False
            out.count = out.want = out.said = None
            out.blocked = BRAKED

    def flush(self, bus: Bus) -> None:
        """Write what is due, if there is room; in the line's thread."""
        if self._clock() >= self._free_at:
            self.flush_now(bus)

    def flush_now(self, bus: Bus) -> None:
        """Write what is wanted and was not said yet, all at once; in the line's thread."""
        if not self.open:
            return
        said = [(out, out.want) for out in self._all() if out.want is not None and out.want != out.said]
        if not said:
            return
        now = self._clock()
        for out, want in said:
            out.said, out.told_at, out.times = want, now, out.times + 1
        answers = bus.write([(out.id, want) for out, want in said])
        if len(said) > FEW:
            self._free_at = self._clock() + (self._wire_s(PACKET_BYTES * len(said)) if answers is None else bus.check_s)

    def place(self, servo: int) -> int | None:
        """Return where a servo is believed to be."""
        seen = self._seen[servo]
        fresh = seen.at > self._played_at and self._clock() - seen.at < PLACE_S
        return seen.position if seen.trusted and fresh else None

    def moving(self, servo: int) -> bool:
        """Return whether a servo may be under way, for the judge of its position; from any thread."""
        out = self.servos[servo]
        return not out.on or out.count is None or self._clock() - out.told_at < MOVING_S

    def watch_rest(self) -> None:
        """Look from now on whether servos stand still."""
        for out in self._all():
            out.still = None

    def unrested(self, since: float) -> list[int]:
        """Return the servos that were not read to stand still since then; those known to be limp before do not
        count."""
        return [out.id for out in self._all() if not self._rests(out, since)]

    def goal_rad(self, out: TargetState) -> float | None:
        """Return the goal of a servo, radians."""
        if out.count is None or not out.on:
            return None
        return round(packets.position_rad(out.count - self._offsets.get(out.id, 0)), 5)

    def position_rad(self, servo: int, count: int) -> float:
        """Return the angle of a count that was read."""
        return round(packets.position_rad(count - self._offsets.get(servo, 0)), 5)

    def _all(self) -> Iterable[TargetState]:
        return self.servos.values()

    def _rests(self, out: TargetState, since: float) -> bool:
        seen = self._seen[out.id]
        if not seen.trusted or seen.at <= since or seen.position is None:
            return False
        if out.still is None or abs(out.still[0] - seen.position) > STILL:
            out.still = (seen.position, seen.at)
        return seen.at - out.still[1] >= STILL_S

    def _unblock(self, gate: ServoGate) -> None:
        if gate.seen:
            for out in self._all():
                if out.id not in gate.wanted:
                    out.blocked, out.carried = "", False

    def _release(self, gate: ServoGate, strength: float) -> None:
        for out in self._all():
            if (out.on or out.carried) and not strength > 0.0:
                self._off(out, LET_GO)
            elif out.on and gate.seen and out.id not in gate.wanted:
                self._off(out, "")

    def _off(self, out: TargetState, why: str) -> None:
        out.known, out.on, out.carried, out.adrift = True, False, False, False
        out.count, out.rest_at = None, inf
        out.blocked = out.blocked or why
        out.want, out.said, out.times = packets.passive(out.id), None, 0

    def _aim(self, out: TargetState, level: int) -> None:
        assert out.count is not None
        weak = self._clock() < out.weak_until
        out.want = packets.move(out.id, WEAKEST if weak else level, out.count)

    def _settle(self, out: TargetState, now: float) -> None:
        """Hold a servo where it is, if its place was unknown, or it rests away from its goal after a stop."""
        here = self.place(out.id)
        if here is None or not out.on:
            return
        if out.adrift:
            out.adrift, out.count = False, packets.legal(here)
            self._aim(out, out.level)
        elif now >= out.rest_at and out.count is not None:
            out.rest_at = inf
            if abs(here - out.count) > SAG:
                out.count = packets.legal(here)
                self._aim(out, out.level)

    def _follow(self, gate: ServoGate, now: float) -> None:
        first = self._first_lease is None
        if first:
            self._first_lease = gate.lease
        for servo, goal in gate.goals.items():
            out = self.servos.get(servo)
            if out is None or not goal.torque > 0.0 or out.blocked:
                continue
            if first and not out.known:
                out.carried = True
            if out.carried and gate.lease not in ("", self._first_lease):
                out.carried = False
            self._follow_one(out, goal, now)

    def _follow_one(self, out: TargetState, goal: ServoGoal, now: float) -> None:
        here = self.place(out.id)
        if goal.position_rad != out.overtaken:
            out.overtaken = None
        if out.carried or goal.position_rad is None or out.overtaken is not None:
            count = out.count if out.on and not out.adrift else None
            count = here if count is None else count
            if count is None:
                out.trouble = "" if out.on else "cannot be held where it is: its place is unknown; give it a position"
                return
        else:
            count = packets.position_count(goal.position_rad) + self._offsets.get(out.id, 0)
        count = packets.legal(count)
        if out.on and out.count is None and here is None and now - self._played_at < PLAYED_S:
            out.led = goal.position_rad if out.led is None else out.led
            return
        if not out.leads(goal, count, here, now - self._applied_at):
            out.weak_until = now + WEAK_S
        elif not out.on:
            out.weak_until = -inf
        if out.count != count:
            out.rest_at = inf
        out.known, out.on, out.adrift, out.trouble = True, True, False, ""
        out.count, out.level = count, packets.torque_level(goal.torque)
        self._aim(out, out.level)

    def _fade(self, strength: float) -> None:
        for out in self._all():
            if out.on and out.count is not None:
                self._aim(out, min(WEAKEST, out.level + round((1.0 - strength) * (WEAKEST + 1 - out.level))))

    def _repeat(self, now: float) -> None:
        """Say again what may not have been heard: a goal that a servo is away from, or to release it."""
        for out in self._all():
            if out.want is None or out.want != out.said:
                continue
            if not out.on:
                if out.times < OFF_TIMES and now - out.told_at >= OFF_AGAIN_S:
                    out.said = None
            elif out.count is not None and now - out.told_at >= AGAIN_S:
                here = self.place(out.id)
                if here is not None and abs(here - out.count) > SAG:
                    out.said = None
