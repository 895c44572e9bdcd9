"""The way of the base from encoder counts. No I/O and no clock of its own: the same events give the same states."""

from collections import deque
from dataclasses import dataclass, field
from math import cos, inf, isfinite, pi, radians, sin

from lbr.messages.attitude import AttitudeState
from lbr.messages.kinematics import Base, Twist, differential
from lbr.messages.motors import RESTS_S, MotorsState
from lbr.messages.odometry import OdometryState
from lbr.operations.odometry import OdometrySettings

WRAP = 2**32
"""The range of counts, signed 32-bit numbers that wrap around."""
JUMP_M = 0.1
JUMP_SHARE = 2.0
LOOK_S = 0.2
"""The age limit of an attitude for a turn; one at rest counts from the last rest of the wheels."""
NO_COUNTS = "the motor controller reports no encoder counts; check its encoders' settings"


@dataclass(frozen=True, slots=True)
class _Mark:
    """Positions of wheels and body at a time: metres along each motor's wheels, radians anticlockwise."""

    time_s: float
    wheels_m: tuple[float, ...]
    yaw_rad: float


@dataclass(slots=True)
class _Run:
    """The counts of one epoch. `idle_s`: the time for which the wheels of each motor were pushed and stood."""

    wheels_m: tuple[float, ...]
    idle_s: tuple[float, ...]
    counts: tuple[int, ...] | None = None
    counted_s: float = -inf
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    distance_m: float = 0.0
    slip_s: float = 0.0
    seen: tuple[str, float, float] | None = None
    by_body: bool = False
    marks: deque[_Mark] = field(default_factory=deque)


class Reckoning:
    """Adds the states of motors and attitude; `state` returns the result."""

    def __init__(self, settings: OdometrySettings, name: str, base: Base | None = None) -> None:
        self._settings = settings
        self._base = base = differential(settings.track_m) if base is None else base
        self._name = name
        self._epochs = 1
        diameters_m = (settings.wheel_diameter_m if one is None else one for one in base.diameters_m)
        self._per_count_m = tuple(pi * one / settings.counts_per_turn for one in diameters_m)
        self._look: tuple[str, float, float] | None = None
        self._look_rests = False
        self._trouble = "the motor driver has not reported yet"
        self._run = self._fresh()
        self._rests = False
        self._rested_s = -inf

    @property
    def epoch(self) -> str:
        """Return the name of the current count of distance."""
        return f"{self._name}-{self._epochs}"

    def look(self, attitude: AttitudeState) -> None:
        """Add the attitude; an invalid one is not used."""
        turned_deg = attitude.turned_deg
        known = attitude.valid and turned_deg is not None and isfinite(turned_deg) and isfinite(attitude.measured_s)
        self._look_rests = attitude.rests
        self._look = (attitude.epoch, turned_deg, attitude.measured_s) if known and turned_deg is not None else None

    def count(self, motors: MotorsState, now: float) -> None:
        """Add the motors' state, which arrived now."""
        counts = self._counts(motors)
        if counts is None:
            self._fail(NO_COUNTS if motors.reason == "" or motors.armed else f"{NO_COUNTS} ({motors.reason})")
            return
        began, self._rests = self._rests and not motors.rests, motors.rests
        self._rested_s = now if motors.rests else self._rested_s
        before, self._run.counts = self._run.counts, counts
        if self._trouble or before is None:
            self._trouble = ""
            self._start(now)
            return
        elapsed_s = now - self._run.counted_s
        if not elapsed_s > 0.0:  # this way round, NaN is no time
            self._run.counts = before
            return
        way_m = tuple(
            _difference(new, old) * metres for new, old, metres in zip(counts, before, self._per_count_m, strict=True)
        )
        most_m = JUMP_M + JUMP_SHARE * self._settings.max_speed_mps * elapsed_s
        if max(map(abs, way_m)) > most_m:  # the controller began to count from zero: the way is unknown
            self._begin_anew()
            self._run.counts = counts
            self._start(now)
            return
        self._run.counted_s = now
        self._move(way_m)
        while began and len(self._run.marks) > 1:  # speeds count from here, and not from the last report at rest
            self._run.marks.popleft()
        self._feel(motors, way_m, elapsed_s)

    def silence(self, now: float) -> None:
        """Check whether the motors have been silent for too long."""
        silent_s = max(self._settings.silent_s, RESTS_S) if self._rests else self._settings.silent_s
        if not self._trouble and not now - self._run.counted_s <= silent_s:
            self._fail(f"the motor driver has been silent for more than {silent_s:g} s")

    def state(self) -> OdometryState:
        """Return the current state."""
        if self._trouble:
            return OdometryState(valid=False, epoch=self.epoch, reason=self._trouble)
        twist, turn_rps = self._speeds()
        return OdometryState(
            valid=True,
            epoch=self.epoch,
            counted_s=self._run.counted_s,
            x_m=round(self._run.x_m, 4),
            y_m=round(self._run.y_m, 4),
            yaw_rad=round(self._run.yaw_rad, 4),
            distance_m=round(self._run.distance_m, 4),
            speed_mps=round(twist.vx_mps, 3),
            turn_rps=round(turn_rps, 3),
            stalled=max(self._run.idle_s) >= self._settings.stall_s,
            slipping=self._run.slip_s >= self._settings.slip_s,
            aside_mps=round(twist.vy_mps, 3) if self._base.holonomic else None,
            rests=self._rests,
        )

    def _fail(self, why: str) -> None:
        if not self._trouble:
            self._begin_anew()
        self._trouble = why

    def _begin_anew(self) -> None:
        self._epochs += 1
        self._run = self._fresh()

    def _fresh(self) -> _Run:
        rest = (0.0,) * len(self._base.motors)
        return _Run(wheels_m=rest, idle_s=rest)

    def _counts(self, motors: MotorsState) -> tuple[int, ...] | None:
        """Return the counts of each motor, in the order of the base's; None if one is missing."""
        each = motors.each
        counts = [each[name].counts if name in each else None for name in self._base.motors]
        return None if None in counts else tuple(count for count in counts if count is not None)

    def _start(self, now: float) -> None:
        self._run.counted_s = now
        self._run.seen = self._look
        self._run.marks.append(_Mark(now, self._run.wheels_m, 0.0))

    def _move(self, way_m: tuple[float, ...]) -> None:
        way = self._base.twist(way_m)
        ahead_m, aside_m, by_wheels_rad = way.vx_mps, way.vy_mps, way.wz_rps  # ways, not speeds
        by_body_rad = self._turned_rad()
        turned_rad = by_wheels_rad if by_body_rad is None else by_body_rad
        middle_rad = self._run.yaw_rad + turned_rad / 2
        self._run.x_m += ahead_m * cos(middle_rad) - aside_m * sin(middle_rad)
        self._run.y_m += ahead_m * sin(middle_rad) + aside_m * cos(middle_rad)
        self._run.yaw_rad += turned_rad
        self._run.distance_m += ahead_m
        self._run.wheels_m = tuple(before + now for before, now in zip(self._run.wheels_m, way_m, strict=True))
        mark = _Mark(self._run.counted_s, self._run.wheels_m, self._run.yaw_rad)
        self._run.marks.append(mark)
        while len(self._run.marks) > 2 and mark.time_s - self._run.marks[1].time_s >= self._settings.speed_window_s:
            self._run.marks.popleft()
        self._run.by_body = by_body_rad is not None

    def _turned_rad(self) -> float | None:
        """Return the turn of the body since the last counts by the attitude, anticlockwise; None if unknown."""
        before, self._run.seen = self._run.seen, self._look
        if before is None or self._look is None or before[0] != self._look[0]:
            return None
        looked_s = max(self._look[2], self._rested_s) if self._look_rests else self._look[2]
        return -radians(self._look[1] - before[1]) if self._run.counted_s - looked_s <= LOOK_S else None

    def _feel(self, motors: MotorsState, way_m: tuple[float, ...], elapsed_s: float) -> None:
        """Detect a pushed wheel that stands, and wheels that turn differently from the body."""
        settings = self._settings
        each = motors.each
        wheels = [each[name] for name in self._base.motors]
        pushed = [
            abs(wheel.power) >= settings.stall_power or abs(wheel.amps_a or 0.0) >= settings.stall_a for wheel in wheels
        ]
        self._run.idle_s = tuple(
            idle_s + elapsed_s if push and step_m == 0.0 else 0.0
            for idle_s, push, step_m in zip(self._run.idle_s, pushed, way_m, strict=True)
        )
        twist, by_body_rps = self._speeds()
        by_wheels_rps = twist.wz_rps
        apart_rps = abs(by_wheels_rps - by_body_rps)
        faster_rps = max(abs(by_wheels_rps), abs(by_body_rps))
        slips = self._run.by_body and apart_rps > max(radians(settings.slip_dps), settings.slip_share * faster_rps)
        self._run.slip_s = self._run.slip_s + elapsed_s if slips else 0.0

    def _speeds(self) -> tuple[Twist, float]:
        """Return the motion of the base by its wheels, and the turn of the body, over the last moments."""
        first, last = self._run.marks[0], self._run.marks[-1]
        elapsed_s = last.time_s - first.time_s
        if elapsed_s <= 0.0:
            return Twist(), 0.0
        speeds = [(now - then) / elapsed_s for now, then in zip(last.wheels_m, first.wheels_m, strict=True)]
        return self._base.twist(speeds), (last.yaw_rad - first.yaw_rad) / elapsed_s


def _difference(count: int, before: int) -> int:
    """Return the difference of two readings of a 32-bit count."""
    return (count - before + WRAP // 2) % WRAP - WRAP // 2
