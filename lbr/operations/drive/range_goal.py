"""Coming to rest at a range: how far it is by the readings and by the way since, how fast, and whether the base stands there."""

from math import isnan

from msgspec import Struct
from msgspec.structs import replace

from lbr.operations.drive.rules import allowed_mps
from lbr.operations.drive.settings import DriveSettings

NEAR_M = 0.005
"""So near the target a base that stands has reached it: a creep is no shorter."""
SHARE = 0.25
"""Of what a reading and the expectation differ by, from the fourth reading on: readings of a sonar waver by a centimetre."""
JUMP_M = 0.05
"""A reading that differs by more is of something else: it counts alone."""
SETTLED = 3
"""Readings at rest before it is judged."""
HALT_TICKS = 2.0
"""From a setpoint to the wheels that obey it."""


class RangeGoal(Struct, frozen=True, kw_only=True):
    """The way that is left to a range; `readings` is how many have told it since the last jump.

    `halts`: the base brakes to its rest there, or stands, with `rested` readings since.
    """

    left_m: float
    readings: int = 1
    halts: bool = False
    rested: int = 0


def read(way: RangeGoal, left_m: float, ahead_mps: float, lag_s: float, *, stands: bool) -> RangeGoal:
    """Return the way after a reading, which was measured `lag_s` ago."""
    rested = way.rested + 1 if stands and way.halts else 0
    here_m = left_m - ahead_mps * lag_s
    if not abs(here_m - way.left_m) <= JUMP_M:
        return replace(way, left_m=here_m, readings=1, rested=rested)
    readings = way.readings + 1
    share = max(SHARE, 1.0 / readings)
    return replace(way, left_m=way.left_m + share * (here_m - way.left_m), readings=readings, rested=rested)


def driven(way: RangeGoal, ahead_m: float, ahead_mps: float, settings: DriveSettings) -> RangeGoal:
    """Return the way after a step ahead: it halts where the base will come to rest, and goes on from rest if that was short."""
    left_m = way.left_m - ahead_m
    if way.halts:
        again = way.rested >= SETTLED and left_m > NEAR_M
        return replace(way, left_m=left_m, halts=not again, rested=0 if again else way.rested)
    rolls_m = ahead_mps * HALT_TICKS / settings.rate_hz + ahead_mps * ahead_mps / (2 * settings.brake_mps2)
    return replace(way, left_m=left_m, halts=not left_m > rolls_m)  # this way round, NaN halts


def power(way: RangeGoal, asked: float, settings: DriveSettings) -> float:
    """Return the power now, `asked` at most: less near the range, by what the rules know of braking."""
    if way.halts or isnan(way.left_m):
        return 0.0
    return min(asked, max(allowed_mps(way.left_m, settings) / settings.max_speed_mps, settings.creep_power))


def is_over(way: RangeGoal) -> bool:
    """Say whether the base stands at the range."""
    return way.halts and way.rested >= SETTLED and way.left_m <= NEAR_M
