"""The belief about the odometry: distance and speed of the base, and whether its wheels stall or slip."""

from math import inf, isfinite, nan

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.motors import RESTS_S
from lbr.messages.odometry import OdometryState
from lbr.operations.drive.settings import DriveSettings

LATE_S = 0.3
JUMP_M = 0.2
JUMP_SHARE = 2.0


class OdometryView(Struct, frozen=True, kw_only=True):
    """The newest odometry; `trouble` explains why no distance can be driven by it. Backwards is negative."""

    trouble: str = "no odometry has arrived yet"
    epoch: str = ""
    distance_m: float = nan
    speed_mps: float = 0.0
    stalled: bool = False
    slipping: bool = False
    seen: float = nan
    rests: bool = False


UNKNOWN = OdometryView()


def see(before: OdometryView, odometry: OdometryState, arrived: float, settings: DriveSettings) -> OdometryView:
    """Return the belief after new odometry; an overtaken one changes nothing."""
    counted_s = nan if odometry.counted_s is None else odometry.counted_s
    seen = min(counted_s, arrived)  # this way round, NaN stays NaN
    if seen <= before.seen and odometry.valid and odometry.epoch == before.epoch:
        return before
    distance_m = nan if odometry.distance_m is None else odometry.distance_m
    speed_mps = nan if odometry.speed_mps is None else odometry.speed_mps
    newest = OdometryView(
        trouble=_trouble(odometry, (seen, distance_m, speed_mps)),
        epoch=odometry.epoch,
        distance_m=distance_m,
        speed_mps=speed_mps,
        stalled=odometry.stalled,
        slipping=odometry.slipping,
        seen=seen,
        rests=odometry.rests,
    )
    if newest.trouble or before.trouble or newest.epoch != before.epoch:
        return newest
    way_m = distance_m - before.distance_m
    most_m = JUMP_M + JUMP_SHARE * settings.max_speed_mps * (seen - before.seen)
    jumped = f"the odometry jumped by {way_m:.2f} m within {seen - before.seen:.2f} s"
    return newest if abs(way_m) <= most_m else replace(newest, trouble=jumped)


def not_known(odometry: OdometryView, now: float, since: float = -inf) -> str:
    """Return why no distance can be driven now, or an empty string; NaN in a comparison means that it cannot.

    Odometry at rest may be older before a motion; from its start (`since`) it has the usual time to be renewed.
    """
    if odometry.trouble:
        return odometry.trouble
    longest_s = RESTS_S if odometry.rests and since == -inf else LATE_S
    seen = max(odometry.seen, since) if odometry.rests else odometry.seen
    return "" if now - seen <= longest_s else f"the odometry is older than {longest_s:g} s"


def _trouble(odometry: OdometryState, numbers: tuple[float, ...]) -> str:
    if not odometry.valid:
        return f"the odometry is not known: {odometry.reason or 'no reason given'}"
    return "" if all(isfinite(number) for number in numbers) else "the odometry makes no sense: a number is missing"
