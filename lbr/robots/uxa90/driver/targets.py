"""The orders for every servo, as packets; all changed ones leave in one write. Lives in the loop's thread.

Only `flush` and `brake` run in the line's thread: they write the orders of that moment.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from math import inf

from lbr.drivers.servos.gate import ServoGate
from lbr.drivers.servos.torque import Target, Torque
from lbr.messages.servos import ServoGoal
from lbr.robots.uxa90.driver import packets
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.packets import PACKET_BYTES, WEAKEST
from lbr.robots.uxa90.driver.plausibility import Seen

PLACE_S = 0.6
"""The age limit of a position: twelve sweeps at the usual 20 a second. Chosen, not measured."""
WEAK_S = 2.0
"""The time at the weakest level for a servo whose position was unknown, or far from its goal. Chosen, not measured."""
SAG = 8
"""The distance from its goal at which a servo may rest under its load, in counts. Chosen, not measured on a real robot.
"""
REST_S = 0.3
AGAIN_S = 1.0
MOVING_S = 1.0
OFF_AGAIN_S, OFF_TIMES = 0.1, 3
"""The repetitions of a release, because a released servo does not report it."""
STILL, STILL_S = 2, 0.04
"""The range in counts, and the time, within which a servo stands still."""
FEW = 8
"""The number of servos in a write after which the line needs a pause."""
UNPLACED = "cannot be held where it is: its place is unknown; give it a position"
PLAYED_S = 1.0
"""The time after a motion of the main board in which servos get no goal before their positions are read."""
NEAR = 12
"""The distance in counts at which a servo may go to its goal at the requested torque."""
STRIDE, FASTEST_CPS = 24, 400.0
"""The largest step from goal to goal of a servo that is led step by step: counts, plus counts a second."""
LIMP = "was released by the main board's motion; switch its torque off, then on"
BRAKED = "was braked by the emergency stop; switch its torque off, then on"


@dataclass(slots=True)
class TargetState(Target):
    """One servo. `count`: its goal, None if unknown.

    `want` is the due packet, `sent` the last written one, `sent_at` its time. `carried`: it may have had torque before
    the line was opened; it is held at its position until a new motion begins. `overtaken`: a goal from before a stop,
    which is ignored. `led`: the position to which a motion of the main board led it.
    """

    count: int | None = None
    level: int = 0
    want: bytes | None = None
    sent: bytes | None = None
    sent_at: float = -inf
    times: int = 0
    weak_until: float = -inf
    rest_at: float = inf
    carried: bool = False
    overtaken: float | None = None
    led: float | None = None
    still: tuple[int, float] | None = None

    @property
    def energised(self) -> bool:
        """Return whether it has torque by this driver, or may have it from the one before."""
        return self.on or self.carried

    def unblock(self) -> None:
        """Allow torque again, as for any other servo."""
        self.blocked, self.carried = "", False

    def leads(self, goal: ServoGoal, count: int, present: int | None, round_s: float) -> bool:
        """Return whether a goal is at the servo, or near its goal of `round_s` ago; otherwise the servo would jump."""
        if present is not None and abs(present - count) <= NEAR:
            return True
        if self.on and self.count is not None:
            return abs(self.count - count) <= STRIDE + FASTEST_CPS * round_s
        return self.on and goal.position_rad == self.led


class ServoTargets(Torque[TargetState]):
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
        super().__init__(servos, lambda servo: TargetState(servo, blocked=blocked), clock)
        self.open = False
        """True if servos can get orders now."""
        self._seen = seen
        self._wire_s = wire_s
        self._offsets = offsets or {}
        self._first_lease: str | None = None
        self._free_at = self._played_at = -inf
        self._applied_at = clock()

    @property
    def unknown(self) -> bool:
        """Return whether the torque of any servo is unknown."""
        return any(not target.known for target in self._all())

    @property
    def due(self) -> bool:
        """Return whether there is a packet to write."""
        return self.open and any(target.want != target.sent for target in self._all())

    def apply(self, gate: ServoGate, strength: float) -> None:
        """Update the orders by the gate's state and the servos' positions."""
        now = self._clock()
        if self.advance(gate, strength):
            self.freeze()
        for target in self._all():
            self._settle(target, now)
        if gate.follows and self.guarded:
            self._follow(gate, now)
        if strength < 1.0:
            self._fade(strength)
        self._repeat(now)
        self._applied_at = now

    def freeze(self) -> None:
        """Make servos hold: at their last goal, a step away, and once they rest, at their position then."""
        now = self._clock()
        for target in self._all():
            if not target.on:
                continue
            present = self.place(target.id)
            if target.count is None:
                target.adrift = True
            elif now < target.weak_until and present is None:
                self.off([target], "was stopped on its way from an unknown place; switch its torque off, then on")
            else:
                if present is not None and now < target.weak_until:
                    target.count = present
                target.rest_at = now + REST_S
                target.sent = None
                self._aim(target, target.level)

    def release(self, why: str) -> None:
        """Switch the torque of every servo off."""
        self.off(list(self._all()), why)

    def off(self, targets: Sequence[TargetState], why: str) -> None:
        """Switch the torque of these servos off with the next write."""
        for target in targets:
            target.known, target.on, target.carried, target.adrift = True, False, False, False
            target.count, target.rest_at = None, inf
            target.blocked = target.blocked or why
            target.want, target.sent, target.times = packets.passive(target.id), None, 0

    def played(self, *, limp: bool) -> None:
        """Note a motion of the main board: servos have torque, with unknown goals, or none if it was `limp`."""
        self._played_at = self._clock()
        for target in self._all():
            target.known, target.on, target.carried, target.adrift = True, not limp, False, False
            target.count = target.want = target.sent = None
            target.level, target.rest_at, target.weak_until, target.led = 0, inf, -inf, None
            target.blocked = LIMP if limp else ""

    def loose(self, goals: Mapping[int, ServoGoal]) -> None:
        """Hold every servo with torque at its position, as soon as that is read again; the present `goals` are void."""
        self._played_at = self._clock()
        for target in self._all():
            if target.on:
                target.count, target.want, target.sent = None, None, None
                target.overtaken = goals[target.id].position_rad if target.id in goals else None
                target.adrift = True

    def brake(self, bus: Bus) -> None:
        """Short all motors; in the line's thread. One servo answers for all."""
        bus.say(packets.BREAK_ALL, 1)

    def braked(self) -> None:
        """Note that all servos are braked."""
        for target in self._all():
            target.known, target.on, target.carried, target.adrift = True, False, False, False
            target.count = target.want = target.sent = None
            target.blocked = BRAKED

    def flush(self, bus: Bus) -> None:
        """Write the due packets, if there is room; in the line's thread."""
        if self._clock() >= self._free_at:
            self.flush_now(bus)

    def flush_now(self, bus: Bus) -> None:
        """Write all due packets at once; in the line's thread."""
        if not self.open:
            return
        now, packets_due = self._clock(), []
        for target in self._all():
            if target.want is not None and target.want != target.sent:
                target.sent, target.sent_at, target.times = target.want, now, target.times + 1
                packets_due.append((target.id, target.want))
        if not packets_due:
            return
        answers, count = bus.write(packets_due), len(packets_due)
        if count > FEW:
            self._free_at = self._clock() + (self._wire_s(PACKET_BYTES * count) if answers is None else bus.check_s)

    def place(self, servo: int) -> int | None:
        """Return the trusted position of a servo, None without one."""
        seen = self._seen[servo]
        fresh = seen.at > self._played_at and self._clock() - seen.at < PLACE_S
        return seen.position if seen.trusted and fresh else None

    def moving(self, servo: int) -> bool:
        """Return whether a servo may be moving, for the judge of its position; from any thread."""
        target = self.servos[servo]
        return not target.on or target.count is None or self._clock() - target.sent_at < MOVING_S

    def watch_rest(self) -> None:
        """Watch from now on whether servos stand still."""
        for target in self._all():
            target.still = None

    def unrested(self, since: float) -> list[int]:
        """Return the servos without a reading of standing still since then; servos known to be limp before do not
        count."""
        return [target.id for target in self._all() if not self._rests(target, since)]

    def goal_rad(self, target: TargetState) -> float | None:
        """Return the goal of a servo, radians."""
        if target.count is None or not target.on:
            return None
        return round(packets.position_rad(target.count - self._offsets.get(target.id, 0)), 5)

    def position_rad(self, servo: int, count: int) -> float:
        """Return the angle of a count that was read."""
        return round(packets.position_rad(count - self._offsets.get(servo, 0)), 5)

    def _rests(self, target: TargetState, since: float) -> bool:
        seen = self._seen[target.id]
        if not seen.trusted or seen.at <= since or seen.position is None:
            return False
        if target.still is None or abs(target.still[0] - seen.position) > STILL:
            target.still = (seen.position, seen.at)
        return seen.at - target.still[1] >= STILL_S

    def _aim(self, target: TargetState, level: int) -> None:
        assert target.count is not None
        weak = self._clock() < target.weak_until
        target.want = packets.move(target.id, WEAKEST if weak else level, target.count)

    def _settle(self, target: TargetState, now: float) -> None:
        """Hold a servo at its position, if that was unknown, or it rests away from its goal after a stop."""
        present = self.place(target.id)
        if present is None or not target.on:
            return
        if target.adrift:
            target.adrift, target.count = False, packets.legal(present)
            self._aim(target, target.level)
        elif now >= target.rest_at and target.count is not None:
            target.rest_at = inf
            if abs(present - target.count) > SAG:
                target.count = packets.legal(present)
                self._aim(target, target.level)

    def _follow(self, gate: ServoGate, now: float) -> None:
        first = self._first_lease is None
        if first:
            self._first_lease = gate.lease
        for servo, goal in gate.goals.items():
            target = self.servos.get(servo)
            if target is None or not goal.torque > 0.0 or target.blocked:
                continue
            if first and not target.known:
                target.carried = True
            if target.carried and gate.lease not in ("", self._first_lease):
                target.carried = False
            self._follow_one(target, goal, now)

    def _follow_one(self, target: TargetState, goal: ServoGoal, now: float) -> None:
        present = self.place(target.id)
        if goal.position_rad != target.overtaken:
            target.overtaken = None
        if target.carried or goal.position_rad is None or target.overtaken is not None:
            count = target.count if target.on and not target.adrift else None
            count = present if count is None else count
            if count is None:
                target.trouble = "" if target.on else UNPLACED
                return
        else:
            count = packets.position_count(goal.position_rad) + self._offsets.get(target.id, 0)
        count = packets.legal(count)
        if target.on and target.count is None and present is None and now - self._played_at < PLAYED_S:
            target.led = goal.position_rad if target.led is None else target.led
            return
        if not target.leads(goal, count, present, now - self._applied_at):
            target.weak_until = now + WEAK_S
        elif not target.on:
            target.weak_until = -inf
        if target.count != count:
            target.rest_at = inf
        target.known, target.on, target.adrift, target.trouble = True, True, False, ""
        target.count, target.level = count, packets.torque_level(goal.torque)
        self._aim(target, target.level)

    def _fade(self, strength: float) -> None:
        for target in self._all():
            if target.on and target.count is not None:
                self._aim(target, min(WEAKEST, target.level + round((1.0 - strength) * (WEAKEST + 1 - target.level))))

    def _repeat(self, now: float) -> None:
        """Repeat packets that may have been lost: a goal that a servo is away from, or a release."""
        for target in self._all():
            if target.want is None or target.want != target.sent:
                continue
            if not target.on:
                if target.times < OFF_TIMES and now - target.sent_at >= OFF_AGAIN_S:
                    target.sent = None
            elif target.count is not None and now - target.sent_at >= AGAIN_S:
                present = self.place(target.id)
                if present is not None and abs(present - target.count) > SAG:
                    target.sent = None
