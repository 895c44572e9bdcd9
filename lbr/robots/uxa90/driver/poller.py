"""Continuous reading of servos, a few in one write, and the trusted readings of each. Lives in the line's thread."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf

from lbr.drivers.servos.rest import Rest
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.packets import HEAD, position_rad
from lbr.robots.uxa90.driver.plausibility import Policy, Seen, doubted, judged, silent

MISSES = 2
AGAIN_FIRST_S, AGAIN_MOST_S = 0.5, 8.0
IDLE_S = 0.02
FIRST_SWEEPS = 8
"""The number of sweeps in immediate succession at the start, so that positions are trusted soon."""
BETTER_ALONE = 3
BUSY_S, WARY_S = 0.1, 5.0
"""The time after a write, and after lost answers, in which an answer is confirmed before the next question."""
STATISTICS_S = 1.0
SILENT = "does not answer"


@dataclass(slots=True)
class _Servo:
    misses: int = 0
    again: float = -inf
    pause_s: float = AGAIN_FIRST_S


class Poller:
    """Does one transaction at each `turn`. `seen` is the newest of each servo, `sweep` counts complete rounds.

    `reading`: whether servos may be asked now. `moving` returns whether a servo may be moving.
    """

    def __init__(
        self,
        servos: Sequence[int],
        clock: Callable[[], float],
        period_s: float,
        policy: Policy,
        together: int,
        *,
        moving: Callable[[int], bool] = lambda _servo: True,
        tell: Callable[[str, str, str], None] = lambda _kind, _text, _level: None,
        rest: Rest | None = None,
        rest_period_s: float = 0.0,
    ) -> None:
        self.seen = {servo: Seen() for servo in servos}
        self.sweep = 0
        self.ended = -inf
        self.sweep_s = 0.0
        self.sweeps_hz = self.states_hz = 0.0
        self.heard_at = -inf
        self.reading = False
        self._servos = {servo: _Servo() for servo in servos}
        self._clock = clock
        self._period_s = period_s
        self._policy = policy
        self._together = together
        self._moving = moving
        self._tell = tell
        self._rest = rest or Rest(clock)
        self._rest_period_s = rest_period_s
        self._groups: deque[list[int]] = deque()
        self._under_way = False
        self._quick = FIRST_SWEEPS
        self._apart: set[int] = set()
        self._apart_well = 0
        self._began = self._due = -inf
        self._counted = (-inf, 0, 0)
        self._states = self._unasked = 0

    @property
    def all_silent(self) -> bool:
        """Return whether every servo was asked in vain."""
        return all(servo.misses >= MISSES for servo in self._servos.values())

    @property
    def judged_all(self) -> bool:
        """Return whether every servo is known: its position trusted (read, without trust), or its silence certain."""
        untrusted = self._policy == "never"
        return all(seen.trusted or seen.reason or (untrusted and seen.raw is not None) for seen in self.seen.values())

    def afresh(self) -> None:
        """Start anew, with fast sweeps: after a pause in reading, servos may be anywhere."""
        self._groups.clear()
        self._under_way, self._quick, self._due = False, FIRST_SWEEPS, -inf
        for number, servo in self._servos.items():
            servo.misses, servo.again = 0, -inf
            self.seen[number] = silent(self.seen[number], "")

    def turn(self, bus: Bus) -> float:
        """Ask the next group; return the seconds until there is more to do."""
        bus.drain()
        self.take(bus)
        if not (self.reading and self._period_s):
            self._groups.clear()
            self._under_way = False
            return IDLE_S
        if not bus.quiet():
            return min(IDLE_S, bus.wait_s)
        now = self._clock()
        wary = now - bus.written_at < BUSY_S or now - bus.disturbed_at < WARY_S
        if bus.doubtful and (wary if self._groups else not self._all_since(self._began)):
            return bus.check_s
        if self._groups:
            self._ask(bus, self._groups.popleft())
            return 0.0
        return self._next()

    def take(self, bus: Bus) -> None:
        """Judge the confirmed answers; after stray bytes, trust is not gained by answers before them."""
        if bus.unasked != self._unasked:
            self._unasked = bus.unasked
            for servo, seen in self.seen.items():
                self.seen[servo] = seen if seen.trusted else doubted(seen)
        while bus.answers:
            servo, answer, at = bus.answers.popleft()
            if servo in self.seen:
                self.seen[servo] = judged(self.seen[servo], answer, at, self._policy, moving=self._moving(servo))
                self._servos[servo].misses, self._servos[servo].pause_s = 0, AGAIN_FIRST_S
                self._rest.look(servo, position_rad(answer.position), answer.load / (HEAD - 1))
                self._states += 1
                self.heard_at = at

    def _all_since(self, when: float) -> bool:
        return all(seen.raw_at >= when or self._servos[servo].misses >= MISSES for servo, seen in self.seen.items())

    def _next(self) -> float:
        """End a sweep, and begin the next when it is due."""
        now = self._clock()
        if self._under_way:
            self._under_way = False
            self.sweep += 1
            self.ended, self.sweep_s = now, now - self._began
            self._count(now)
            self._quick -= self._quick > 0
        due = self._due + self._rest_period_s if self._rest.lasts else self._due
        if now < due and not self._quick:
            return due - now
        self._began, self._due = now, max(self._due + self._period_s, now)
        self._under_way = True
        ids = list(self._servos)
        turned = ids[self.sweep % len(ids) :] + ids[: self.sweep % len(ids)]
        present = [servo for servo in turned if self._servos[servo].misses < MISSES]
        known = now - self._period_s / 2.0 if not self._quick else inf
        present = [servo for servo in present if self.seen[servo].raw_at < known]
        self._groups.extend(present[at : at + self._together] for at in range(0, len(present), self._together))
        quiet_ones = [servo for servo in turned if self._servos[servo].misses >= MISSES]
        overdue = [servo for servo in quiet_ones if self._servos[servo].again <= now]
        self._groups.extend([servo] for servo in overdue[:1])
        return 0.0 if self._groups else self._period_s

    def _ask(self, bus: Bus, group: list[int]) -> None:
        answers = bus.read(group)
        if answers is not None:
            self._answered(group)
        elif bus.cut_short:
            self._groups.appendleft(group)
        elif len(group) > 1:
            self._apart = set(group)
            self._groups.extendleft([servo] for servo in reversed(group))
        else:
            self._missed(group[0])

    def _answered(self, group: list[int]) -> None:
        """Ask servos one by one from now on if they answer only that way."""
        if len(group) > 1:
            self._apart_well = 0
        elif group[0] in self._apart:
            self._apart.discard(group[0])
            if not self._apart and self._together > 1:
                self._apart_well += 1
                if self._apart_well >= BETTER_ALONE:
                    self._together = 1
                    self._tell(
                        "one_by_one", "servos do not answer several questions in one write; asking singly", "info"
                    )

    def _missed(self, number: int) -> None:
        servo = self._servos[number]
        self._apart.clear()
        servo.misses += 1
        if servo.misses <= MISSES:
            self._rest.stir()
        if servo.misses < MISSES:
            self._groups.append([number])
            return
        self.seen[number] = silent(self.seen[number], SILENT)
        servo.again = self._clock() + servo.pause_s
        servo.pause_s = min(servo.pause_s * 2.0, AGAIN_MOST_S)

    def _count(self, now: float) -> None:
        at, sweeps, states = self._counted
        if now - at >= STATISTICS_S:
            if at > -inf:
                self.sweeps_hz, self.states_hz = (
                    (self.sweep - sweeps) / (now - at),
                    (self._states - states) / (now - at),
                )
            self._counted = (now, self.sweep, self._states)
