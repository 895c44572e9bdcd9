"""The approach to a range: the distance by readings and by the way since, the speed, and the arrival."""

from itertools import pairwise
from math import hypot, isnan, nan, sqrt

from msgspec import Struct
from msgspec.structs import replace

from lbr.operations.drive import odometry_view
from lbr.operations.drive.odometry_view import OdometryView
from lbr.operations.drive.rules import allowed_mps
from lbr.operations.drive.settings import DriveSettings

NEAR_M = 0.005
"""The distance from the target at which a standing base has arrived: a creep is no shorter."""
NOISE_M = 0.01
"""Standard deviation of a reading of a standing base: a sonar wavers by a centimetre."""
LATE_S = 0.05
"""Standard deviation of the age of a reading: it makes readings of a moving base less exact."""
DRIFT = 0.02
"""The error of the odometry, as a share of the way."""
JUMP_M = 0.05
"""The difference from which a reading belongs to another object, and counts alone."""
SETTLED = 3
"""The number of readings at rest before the arrival is judged."""
HALT_TICKS = 2.0
"""The ticks from a setpoint to its effect on the wheels."""
KEPT_S = 0.3
"""The greatest age of a reading."""

Mark = tuple[float, float]
"""A time, and the way of the base by then."""


class RangeGoal(Struct, frozen=True, kw_only=True):
    """A way to a range: `whole_m` from its beginning, with the standard deviation `error_m`.

    `marks` are times and ways, the last one by the odometry's `counted_m` of its `epoch`. `since_m` is the way since
    then by the setpoint. `sense` is 1 ahead and -1 back. `halts`: the base brakes to its rest there, or stands, with
    `rested` readings since.
    """

    whole_m: float
    marks: tuple[Mark, ...]
    sense: float = 1.0
    error_m: float = NOISE_M
    since_m: float = 0.0
    counted_m: float = nan
    epoch: str = ""
    halts: bool = False
    rested: int = 0

    @property
    def left_m(self) -> float:
        """Return the remaining distance."""
        return self.whole_m - self.marks[-1][1] - self.since_m


def read(way: RangeGoal, left_m: float, measured_s: float, ahead_mps: float, *, stands: bool) -> RangeGoal:
    """Return the way after a reading, which weighs more if little is known, and if the base is slow."""
    rested = way.rested + 1 if stands and way.halts else 0
    whole_m, reading_error_m = left_m + _gone_m(way, measured_s, ahead_mps), hypot(NOISE_M, ahead_mps * LATE_S)
    apart_m = whole_m - way.whole_m
    if not abs(apart_m) <= JUMP_M:
        return replace(way, whole_m=whole_m, error_m=reading_error_m, rested=rested)
    share = way.error_m**2 / (way.error_m**2 + reading_error_m**2)
    return replace(way, whole_m=way.whole_m + share * apart_m, error_m=way.error_m * sqrt(1.0 - share), rested=rested)


def driven(
    way: RangeGoal, odometry: OdometryView, ahead_mps: float, elapsed_s: float, now: float, settings: DriveSettings
) -> RangeGoal:
    """Return the way after a step at a speed: it halts where the base will come to rest, and continues if that was
    short."""
    way = _counted(way, odometry, ahead_mps, elapsed_s, now)
    if way.halts:
        again = way.rested >= SETTLED and way.left_m > NEAR_M
        return replace(way, halts=not again, rested=0 if again else way.rested)
    rolls_m = ahead_mps * HALT_TICKS / settings.rate_hz + ahead_mps * ahead_mps / (2 * settings.brake_mps2)
    return replace(way, halts=not way.left_m > rolls_m)  # this way round, NaN halts


def power(way: RangeGoal, asked: float, settings: DriveSettings) -> float:
    """Return the power now, `asked` at most: less near the range, as the rules for braking allow."""
    if way.halts or isnan(way.left_m):
        return 0.0
    return min(asked, max(allowed_mps(way.left_m, settings) / settings.max_speed_mps, settings.creep_power))


def is_over(way: RangeGoal) -> bool:
    """Return whether the base stands at the range."""
    return way.halts and way.rested >= SETTLED and way.left_m <= NEAR_M


def _counted(way: RangeGoal, odometry: OdometryView, ahead_mps: float, elapsed_s: float, now: float) -> RangeGoal:
    """Return the way by the odometry's newest distance, or by the setpoint if that is unknown."""
    at_s, gone_m = way.marks[-1]
    known = not (odometry.rests or odometry_view.not_known(odometry, now))
    if not known or odometry.epoch != way.epoch:
        way = _marked(way, (now, gone_m + ahead_mps * elapsed_s))
    elif odometry.seen > at_s:
        way = _marked(way, (odometry.seen, gone_m + way.sense * (odometry.distance_m - way.counted_m)))
    since_m = ahead_mps * (now - way.marks[-1][0])
    epoch, counted_m = (odometry.epoch, odometry.distance_m) if known else ("", nan)
    return replace(way, since_m=since_m, epoch=epoch, counted_m=counted_m)


def _marked(way: RangeGoal, mark: Mark) -> RangeGoal:
    kept = tuple(earlier for earlier in way.marks if earlier[0] > mark[0] - KEPT_S) or way.marks[-1:]
    return replace(way, marks=(*kept, mark), error_m=way.error_m + DRIFT * abs(mark[1] - way.marks[-1][1]))


def _gone_m(way: RangeGoal, at_s: float, ahead_mps: float) -> float:
    """Return the way of the base by a time."""
    last_s, last_m = way.marks[-1]
    if at_s >= last_s:
        return last_m + ahead_mps * (at_s - last_s)
    for (before_s, before_m), (after_s, after_m) in pairwise(way.marks):
        if before_s <= at_s < after_s:
            return before_m + (after_m - before_m) * (at_s - before_s) / (after_s - before_s)
    return way.marks[0][1]
