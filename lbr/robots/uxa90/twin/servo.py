"""An emulated SAM servo: its packets, its answers, and the state of its motor.

Speeds and stiffness at a torque level are guesses: no data sheet of these servos was found. Positions are the main
board's nominal counts. The fine ones of 14 bits are the servo's own, without the main board's correction by zeros.
"""

from collections.abc import Mapping
from math import radians

from lbr.robots.uxa90.twin.registers import Registers
from lbr.simulation.measured import ServoDrive, ServoFelt
from lbr.simulation.turning import moved

COUNT_RAD = radians(269.0 / 254.0)
MIDDLE = 127
NO_LOAD_RPS = radians(400.0)
NOMINAL_ZEROS: Mapping[int, int] = {4: 48, 5: 206, 12: 80, 13: 174, 14: 137, 15: 117, 18: 206, 19: 48}
"""The factory's zero of a servo, if it is not the middle of its range."""

_FINE_RAD = radians(333.0 / 4096.0)
_FINE_MIDDLE = 2048
_FINE_MOST = 4095
_TORQUE = (1.0, 0.8, 0.6, 0.4, 0.2)
_SPEED_RPS = tuple(NO_LOAD_RPS * share for share in _TORQUE)
_MOST_SPEED = 30
_DEADBAND_RAD = COUNT_RAD / 4
_SLOPE_RAD = 0.12
_SLOPE_GAIN = 40
"""The distance from its goal at which a servo gives its full torque: half of it at this proportional gain, less with
more."""

_LIMP = ServoDrive()
_BRAKE = ServoDrive(brake=True)


class SamServo:
    """One servo from power-up on; `number` is its place in the body, `registers` have its id on the line.

    Without a world that moves it, it turns by itself, beginning at `counts`.
    """

    def __init__(self, number: int, *, counts: float = MIDDLE, zero: int | None = None) -> None:
        self.number = number
        self.registers = Registers(number)
        self.felt = ServoFelt(position_rad=as_rad(counts))
        self._nominal = NOMINAL_ZEROS.get(number, MIDDLE)
        self.zero = self._nominal if zero is None else zero
        self.powered = True
        self._level: int | None = None
        self._goal_rad = 0.0
        self._way_rps: float | None = None
        self._braked = False
        self._stuck_rad: float | None = None
        self._frozen: ServoFelt | None = None
        self._by_itself = True
        self._at: float | None = None
        self._drive: ServoDrive | None = None

    # Its orders.

    def power(self, *, on: bool) -> None:
        """Switch its supply; without it the servo is limp, and loses all values that are not saved."""
        if on == self.powered:
            return
        self.powered = on
        self.registers.boot()
        self.release()

    def move(self, counts: float, level: int, over_s: float | None = None) -> None:
        """Go to a position within its bounds; in a given time, if that is slower than the level's speed."""
        goal = as_rad(min(max(counts, self.registers["lower"]), self.registers["upper"]))
        self._head_for(goal, level, abs(goal - self.meant_rad) / over_s if over_s else None)

    def move_fine(self, fine: int) -> None:
        """Go to a position of 14 bits, with its present torque, or full torque if it had none."""
        own = (min(fine, _FINE_MOST) - _FINE_MIDDLE) * _FINE_RAD
        self._head_for(own - (self.zero - self._nominal) * COUNT_RAD, self._level or 0, None)

    def release(self) -> None:
        """Switch the torque off."""
        self._level, self._braked, self._drive = None, False, None

    def brake(self) -> None:
        """Short its motor."""
        self._level, self._braked, self._drive = None, True, None

    def hold(self) -> None:
        """Stay at the last commanded position, if there is one."""
        if self._level is not None:
            self._way_rps, self._drive = None, None

    def configure(self, command: int, first: int, second: int) -> bytes | None:
        """Execute a configuration packet; return its answer, or None."""
        answer = self.registers.execute(command, first, second)
        self._drive = None
        return answer

    def suffer(self, *, stuck: bool = False, frozen: bool = False) -> None:
        """Set its faults: it no longer turns, or repeats its last report."""
        self._stuck_rad = (self.felt.position_rad if self._stuck_rad is None else self._stuck_rad) if stuck else None
        self._frozen = (self._frozen or self.felt) if frozen else None
        self._drive = None

    # Its reports.

    @property
    def driven(self) -> bool:
        """Return whether it moves to a goal or holds one."""
        return self._level is not None

    @property
    def meant_rad(self) -> float:
        """Return its commanded position, or the measured one without a command."""
        return self.felt.position_rad if self._level is None else self._goal_rad

    @property
    def counts(self) -> float:
        """Return its commanded or measured position, in nominal counts."""
        return as_counts(self.meant_rad)

    def load(self) -> int:
        """Return the byte of its current."""
        return 254 if self._stuck_rad is not None and self.driven else min(254, round(abs(self._reported.load) * 254))

    def position(self) -> int:
        """Return the byte of its position."""
        return min(254, max(0, round(as_counts(self._reported.position_rad))))

    def fine_position(self) -> int:
        """Return its position in 14 bits."""
        own = self._reported.position_rad + (self.zero - self._nominal) * COUNT_RAD
        return min(_FINE_MOST, max(0, round(own / _FINE_RAD) + _FINE_MIDDLE))

    # Its motor.

    def drive(self) -> ServoDrive:
        """Return the state of its motor; the same object until something has changed."""
        if self._drive is None:
            self._drive = self._meant()
        return self._drive

    def feel(self, felt: ServoFelt, now: float) -> None:
        """Set its state in the world; from then on it does not turn by itself."""
        self._by_itself = False
        self.felt, self._at = felt, now

    def advance(self, now: float) -> None:
        """Turn by itself until now, if no world moves it."""
        if not self._by_itself or (self._at is not None and now <= self._at):
            return
        if self._at is not None:
            self.felt = moved(self.drive(), self.felt, now - self._at, NO_LOAD_RPS)
        self._at = now

    @property
    def _reported(self) -> ServoFelt:
        return self._frozen or self.felt

    def _head_for(self, goal_rad: float, level: int, way_rps: float | None) -> None:
        self._goal_rad, self._level, self._way_rps = goal_rad, level, way_rps
        self._braked, self._drive = False, None

    def _meant(self) -> ServoDrive:
        if not self.powered or (self._level is None and not self._braked):
            return _LIMP
        if self._level is None:
            return _BRAKE
        goal = self._goal_rad if self._stuck_rad is None else self._stuck_rad
        slope = _SLOPE_RAD / (1.0 + self.registers["p"] / _SLOPE_GAIN)
        most = _SPEED_RPS[self._level] * self.registers["speed"] / _MOST_SPEED
        return ServoDrive(
            goal_rad=goal,
            speed_rps=max(0.01, most if self._way_rps is None else min(most, self._way_rps * 1.2)),
            torque=_TORQUE[self._level],
            margins_rad=(_DEADBAND_RAD, _DEADBAND_RAD),
            slopes_rad=(slope, slope),
        )


def as_rad(counts: float) -> float:
    """Return the angle of nominal counts, from the middle of a servo's range."""
    return (counts - MIDDLE) * COUNT_RAD


def as_counts(position_rad: float) -> float:
    """Return an angle in nominal counts."""
    return position_rad / COUNT_RAD + MIDDLE
