"""The two emulated ultrasonic boards: rings of MaxBotix MB1220 that report as lines of JSON; no I/O."""

from collections.abc import Mapping
from random import Random

from lbr.simulation.devices.ultrasonic_ring import Board, UltrasonicFaults
from lbr.simulation.wire import Outbox, noise, strikes

ORDER: tuple[str, ...] = ("forward", "left", "right", "back")
"""The order of the sensors' turns, so that none receives the echo of another."""

MINIMUM_CM = 17
"""The smallest observed reading of the boards; the sensors' datasheet has 20."""
MAXIMUM_CM = 765

_STARTUP_S = 0.5
_PAUSE_S = 0.05
_TRIGGER_S = 0.001
_ECHO_S_PER_CM = 58e-6
_NO_ECHO_S = 0.1
_TICKS_PER_S = {"arduino": 1_000, "parallax": 80_000_000}
_BOTTOM = {"arduino": 0, "parallax": -1}
_OVER_RANGE_CM = 758
_ERROR_CM = 0


class UltrasonicBoard:
    """A board from power-up on. `distances_m` are the distances before its sensors; None or absent: nothing within
    reach.

    `not_there` are missing sensors, `more` those beyond the four of every board. Each sensor's turn lasts as long as
    its echo, so in a report the first reading is the oldest.
    """

    def __init__(
        self,
        board: Board,
        *,
        faults: UltrasonicFaults | None = None,
        seed: int = 0,
        powered_at: float = 0.0,
        more: tuple[str, ...] = (),
    ) -> None:
        self.sensors = (*ORDER, *more)
        self.board = board
        self.faults = faults or UltrasonicFaults()
        self.distances_m: Mapping[str, float | None] = {}
        self.not_there: frozenset[str] = frozenset()
        self._random = Random(seed)
        self._outbox = Outbox()
        self.power_cycle(powered_at)

    def power_cycle(self, now: float) -> None:
        """Restart: sensors settle for half a second; the Arduino then waits for its `g`."""
        self._ranging = self.board == "parallax"
        self._cycle_s = self._told_s = 0.0
        self._next_at = now + _STARTUP_S
        self._last: dict[str, int] = {}
        self._turn = 0
        self._outbox.clear()

    def feed(self, data: bytes, now: float) -> bytes:
        """Receive bytes from the host; return the bytes that have crossed the line back so far."""
        if self.board == "arduino":
            for byte in data:
                self._outbox.received(1, now)
                self._send(b"received: " + bytes((byte,)) + b"\n", now)
                self._obey(byte, now)
        return self.poll(now)

    def poll(self, now: float) -> bytes:
        """Return the bytes that have crossed the line to the host so far."""
        while self._ranging and now >= self._next_at and not self._blocked():
            if self._turn == len(self.sensors):
                self._report(now)
                break
            self._take_turn(self.sensors[self._turn])
        return self._outbox.due(now)

    def next_due(self) -> float | None:
        """Return the soonest time at which this board sends by itself; poll it meanwhile."""
        left = len(self.sensors) - self._turn
        soonest = self._next_at + left * (_TRIGGER_S + MINIMUM_CM * _ECHO_S_PER_CM)
        report = soonest if self._ranging and not self._blocked() else None
        return min((at for at in (self._outbox.next_due(), report) if at is not None), default=None)

    def _obey(self, byte: int, now: float) -> None:
        if byte == ord("g") and not self._ranging:
            self._ranging = True
            self._turn, self._cycle_s = 0, 0.0
            self._next_at = max(self._next_at, now)
        elif byte == ord("s"):
            self._ranging = False

    def _blocked(self) -> bool:
        """Return whether the board waits for an echo that never comes; only the Arduino's firmware gives up."""
        return self.board == "parallax" and bool(self.faults.missing)

    def _take_turn(self, side: str) -> None:
        """Let one sensor measure its distance."""
        if not (self.faults.frozen and side in self._last):
            self._last[side] = self._sense(side)
        turn_s = self._turn_s(side, self._last[side])
        self._cycle_s += turn_s
        self._next_at += turn_s
        self._turn += 1

    def _sense(self, side: str) -> int:
        faults = self.faults
        if side in faults.missing or side in faults.error or side in self.not_there:
            return _ERROR_CM
        if side in faults.over_range:
            return _OVER_RANGE_CM
        pinned: float | None = getattr(faults, f"range_{side}_m", None)
        faced = self.distances_m.get(side) if pinned is None else pinned
        if faced is None:
            return MAXIMUM_CM
        spread_cm = self._random.gauss(0.0, faults.noise_cm) if faults.noise_cm else 0.0
        return max(MINIMUM_CM, min(MAXIMUM_CM, round(faced * 100 + spread_cm)))

    def _report(self, now: float) -> None:
        """Send the measurements with the duration of the previous cycle, and rest."""
        ticks = round(self._told_s * _TICKS_PER_S[self.board])
        fields = ", ".join(f'"{side.capitalize()}": {self._last[side]}' for side in ORDER)
        others = "".join(f', "{side.capitalize()}": {self._last[side]}' for side in self.sensors[len(ORDER) :])
        line = f'{{ "Ranges": {{ {fields}, "Bottom": {_BOTTOM[self.board]}, "Deltat": {ticks}{others}}}}}\r\n'.encode(
            "ascii"
        )
        if strikes(self.faults.garbage, self._random):
            self._send(noise(self._random), now)
        if strikes(self.faults.half_lines, self._random):
            line = line[: self._random.randrange(1, len(line) - 2)]
        self._send(line, now)
        self._told_s, self._cycle_s = _PAUSE_S + self._cycle_s, 0.0
        self._next_at = max(self._next_at + _PAUSE_S, now)
        self._turn = 0

    def _turn_s(self, side: str, range_cm: int) -> float:
        return _TRIGGER_S + (_NO_ECHO_S if side in self.faults.missing else range_cm * _ECHO_S_PER_CM)

    def _send(self, data: bytes, now: float) -> None:
        if not self.faults.silent:
            self._outbox.send(data, now)
