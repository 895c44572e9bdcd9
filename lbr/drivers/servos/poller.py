"""The rounds over the servos of a bus: each sweep reads the motion of every servo, and all else of one of them.

Servos at rest are swept seldom, with all values of several in a sweep; any motion brings the next sweep at once. A
silent servo is left out and searched for now and then, so that it does not slow the others. Runs in the bus's thread.
"""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, inf
from typing import Generic

from lbr.drivers.servos.contract import SETTING_UP, UNSEEN, B, Motion, Seen, SlowState, Snapshot
from lbr.drivers.servos.rest import FULL_S, Rest

MISSES = 4
"""The number of sweeps in a row without an answer that make a servo silent, also at the start. Chosen, not measured: 40
ms at the usual 100 sweeps a second."""
AGAIN_FIRST_S, AGAIN_MOST_S = 0.1, 2.0
SYNC_READ_FAILURES = 3
SINGLY_FIRST_S, SINGLY_MOST_S = 0.5, 30.0
"""The times for which servos are read one by one after failed common reads. A busy machine is late for some sweeps, an
adapter without that feature never answers."""
WAITING_SHARE = 0.1
"""A sweep begins right after goals were written, so that the two do not collide; this share of its period is the wait.
"""
HASTY_S = 0.001
HASTY_LOSSES = 4
"""A slow read that would delay the sweep is not waited for, unless this many in a row were late."""
WRITING_S = 0.02
"""The time for which a servo does not answer after a write of two EEPROM bytes (datasheet: 9 ms each at worst)."""
STATISTICS_S = 1.0


@dataclass(slots=True)
class _Servo:
    id: int
    seen: Seen = field(default_factory=lambda: Seen(reason=UNSEEN))
    misses: int = MISSES
    looks: int = 0
    again: float = -inf
    pause_s: float = AGAIN_FIRST_S

    @property
    def silent(self) -> bool:
        return self.misses >= MISSES


class Poller(Generic[B]):
    """Does one transaction at each `turn`; after the last of a sweep there is a new `snapshot`.

    `prepare` checks each servo before it is swept, also after a silence; it returns what is wrong, or an empty string.
    """

    def __init__(
        self,
        servos: Sequence[int],
        clock: Callable[[], float],
        period_s: float = 0.0,
        prepare: Callable[[B, int], str] = lambda _bus, _servo: "",
        tell: Callable[[str, str, str], None] = lambda _kind, _text, _level: None,
        rest: Rest | None = None,
        rest_period_s: float = 0.0,
    ) -> None:
        self.snapshot = Snapshot(0, -inf, {servo: Seen(reason=UNSEEN) for servo in servos})
        self.heard_at = -inf
        """The time of the last answer of any servo."""
        self._rest = rest or Rest(clock)
        self._rest_period_s = rest_period_s
        self._hurried = False
        """True after a lost answer: then the next sweep is not delayed, even at rest."""
        self._servos = {servo: _Servo(servo) for servo in servos}
        self._clock = clock
        self._period_s = period_s
        self._prepare = prepare
        self._tell = tell
        self._looks: deque[int] = deque()
        self._turns: Iterator[None] = iter(())
        self._slow_turn = 0
        self._due = -inf
        self._began = 0.0
        self._sync_failures = 0
        self._singly_until, self._singly_s = -inf, SINGLY_FIRST_S
        self._singly_reported = False
        self._hasty_losses = 0
        self._written = 0
        self._counted_at = -inf
        self._counted = (0, 0)
        self._states = 0

    def look(self, servos: Sequence[int]) -> None:
        """Read all values of these servos next, before the sweep continues; call it in the bus's thread."""
        self._looks += [servo for servo in servos if servo not in self._looks]

    def turn(self, bus: B) -> float:
        """Do one transaction; return the seconds until the next sweep is due, 0 within a sweep."""
        if self._looks:
            self._read_slow(bus, self._servos[self._looks.popleft()])
            self._looks_seen()
            return 0.0
        for _ in self._turns:
            return 0.0
        now, due = self._clock(), self._due
        if self._rest.lasts and not self._hurried:
            due += self._rest_period_s
        follows = bus.written_all != self._written and due - now < self._period_s / 2
        if now < due and not follows:
            return due - now
        self._due = now + self._period_s * (1.0 + WAITING_SHARE) if follows else max(self._due + self._period_s, now)
        self._began, self._written, self._hurried = now, bus.written_all, False
        self._turns = self._sweep(bus)
        next(self._turns, None)
        return 0.0

    def _sweep(self, bus: B) -> Iterator[None]:
        """Sweep once, with one transaction between two `yield`s."""
        present = [servo for servo in self._servos.values() if not servo.silent]
        slow = self._next_slow(present)
        together = bus.together and self._clock() >= self._singly_until
        if together:
            self._read_together(bus, present)
            yield
        for servo in present:
            if servo in slow:
                self._read_slow(bus, servo)
            elif not together:
                self._read_motion(bus, servo)
            else:
                continue
            yield
        for servo in self._overdue():
            self._seek(bus, servo)
            yield
        if bus.written_all != self._written:
            self._written, self._due = bus.written_all, self._due + self._period_s * WAITING_SHARE
        self._finish(together=bus.together and self._clock() >= self._singly_until)

    def _read_together(self, bus: B, present: list[_Servo]) -> None:
        motions = bus.read_together(tuple(servo.id for servo in present)) if present else []
        if bus.cut_short:
            return
        if motions is not None:
            if present:
                self._sync_failures, self._singly_s = 0, SINGLY_FIRST_S
            for servo, motion in zip(present, motions, strict=True):
                error = None if bus.together_errors else servo.seen.error
                self._note(servo, motion, "does not answer", error=error)
            return
        self._sync_failures, self._hurried = self._sync_failures + 1, True
        if self._sync_failures >= SYNC_READ_FAILURES:
            self._singly_until = self._clock() + self._singly_s
            self._singly_s = min(2.0 * self._singly_s, SINGLY_MOST_S)
            if not self._singly_reported:
                self._singly_reported = True
                text = "reading all servos at once gets no answers; they are read one by one, and now and then at once"
                self._tell("sync_read", text, "warning")

    def _read_motion(self, bus: B, servo: _Servo) -> None:
        motion = bus.read_motion(servo.id)
        if not bus.cut_short:
            self._note(servo, motion, bus.trouble)

    def _read_slow(self, bus: B, servo: _Servo) -> None:
        hasty = self._hasty_losses < HASTY_LOSSES
        state = bus.read_state(servo.id, HASTY_S if hasty else inf)
        if bus.cut_short:
            return
        if state is None:
            self._hasty_losses += hasty
            self._note(servo, None, bus.trouble)
            return
        if hasty:
            self._hasty_losses = 0
        motion, slow = state
        self._note(servo, motion, "says nonsense", slow)

    def _seek(self, bus: B, servo: _Servo) -> None:
        """Search for a silent servo: the longer it has been away, the more rarely."""
        wrong = self._prepare(bus, servo.id)
        if bus.cut_short:
            return
        servo.looks += 1
        begins = servo.seen.reason in {UNSEEN, SETTING_UP} and servo.looks < MISSES
        if begins and wrong not in {"", SETTING_UP}:
            return  # the next sweep searches for it too
        self._see(servo, wrong)
        if wrong == SETTING_UP:
            self._rest.stir()
            servo.again = self._clock() + WRITING_S
            return
        servo.again = self._clock() + servo.pause_s
        servo.pause_s = min(servo.pause_s * 2.0, AGAIN_MOST_S)
        if not wrong:
            self._read_slow(bus, servo)
            if begins and servo.silent:
                self._see(servo, UNSEEN)
                servo.again = -inf

    def _note(
        self,
        servo: _Servo,
        motion: Motion | None,
        trouble: str,
        slow: SlowState | None = None,
        error: int | None = None,
    ) -> None:
        """Store a servo's answer, or its absence; `error` has the error bits if the motion came without."""
        now = self._clock()
        if motion is None:
            self._hurried = self._hurried or not servo.silent
            if 0 < servo.misses < MISSES:
                self._rest.stir()
            servo.misses += 1
            if servo.misses == MISSES:
                servo.again = now + servo.pause_s
                self._tell("servo_silent", f"servo {servo.id} {trouble}; check its cable and power", "warning")
            if servo.silent:
                self._see(servo, reason=trouble)
            return
        error = motion.error if error is None else error
        if servo.silent or error != servo.seen.error:
            self._rest.stir()
        self._rest.look(servo.id, motion.position_rad, motion.load_fraction)
        if servo.silent and servo.seen.at > -inf:
            self._tell("servo_back", f"servo {servo.id} answers again", "info")
        servo.misses, servo.pause_s = 0, AGAIN_FIRST_S
        self.heard_at = now
        self._states += 1
        if slow is None and error != servo.seen.error:
            self.look((servo.id,))
        servo.seen = Seen(motion, now, slow or servo.seen.slow, error)

    def _see(self, servo: _Servo, reason: str) -> None:
        seen = servo.seen
        servo.seen = Seen(seen.motion, seen.at, seen.slow, seen.error, reason)

    def _next_slow(self, present: list[_Servo]) -> list[_Servo]:
        """Return the servos to read in full in this sweep: the next one, and at rest as many as `FULL_S` requires."""
        first, count = self._slow_turn + 1, min(1, len(present))
        if self._rest.lasts:
            count = max(count, min(len(present), ceil(len(present) * self._rest_period_s / FULL_S - 1e-9)))
        self._slow_turn += count
        return [present[turn % len(present)] for turn in range(first, first + count)]

    def _overdue(self) -> list[_Servo]:
        """Return the silent servos to search for in this sweep: all never searched for, or else one."""
        now = self._clock()
        silent = sorted((servo for servo in self._servos.values() if servo.silent), key=lambda servo: servo.again)
        return [servo for servo in silent if servo.again == -inf] or [servo for servo in silent if servo.again <= now][
            :1
        ]

    def _finish(self, *, together: bool) -> None:
        now, rates = self._clock(), (self.snapshot.sweeps_hz, self.snapshot.states_hz)
        if now - self._counted_at >= STATISTICS_S:
            sweeps, states = self._counted
            passed_s = now - self._counted_at
            rates = ((self.snapshot.sweep + 1 - sweeps) / passed_s, (self._states - states) / passed_s)
            self._counted_at, self._counted = now, (self.snapshot.sweep + 1, self._states)
        servos = {servo.id: servo.seen for servo in self._servos.values()}
        self.snapshot = Snapshot(
            self.snapshot.sweep + 1, now, servos, *rates, sweep_s=now - self._began, together=together
        )

    def _looks_seen(self) -> None:
        """Publish the requested readings at once."""
        if not self._looks:
            old = self.snapshot
            self.snapshot = replace(old, servos={servo.id: servo.seen for servo in self._servos.values()})
