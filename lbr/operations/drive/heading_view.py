"""The belief about the attitude: the angle turned, the rate of turn and the heading."""

from math import inf, isfinite, nan

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.attitude import AttitudeState
from lbr.messages.motors import RESTS_S
from lbr.operations.drive.settings import DriveSettings

JUMP_DEG = 5.0
JUMP_SHARE = 1.5
"""The greatest plausible rate of turn, as a multiple of that at full power."""
SMOOTHING = 0.5
BEGAN_S = 0.08
"""The greatest age of a turn's start: a body at rest is reported at once when it begins to turn."""


class HeadingView(Struct, frozen=True, kw_only=True):
    """The newest attitude; `trouble` explains why it cannot be used for turns. Clockwise is positive.

    `seen` is the time of its measurement, `rate_dps` the rate of turn between the last two.
    """

    trouble: str = "no attitude has arrived yet"
    epoch: str = ""
    turned_deg: float = nan
    rate_dps: float = 0.0
    heading_deg: float = nan
    heading_reason: str = "it has not arrived yet"
    seen: float = nan
    rests: bool = False


UNKNOWN = HeadingView()


def see(before: HeadingView, attitude: AttitudeState, arrived: float, settings: DriveSettings) -> HeadingView:
    """Return the belief after a new attitude; an overtaken one changes nothing."""
    seen = min(attitude.measured_s, arrived)  # this way round, NaN stays NaN
    if seen <= before.seen and attitude.valid and attitude.epoch == before.epoch:
        return before
    turned_deg = nan if attitude.turned_deg is None else attitude.turned_deg
    newest = HeadingView(
        trouble=_trouble(attitude, turned_deg, seen),
        epoch=attitude.epoch,
        turned_deg=turned_deg,
        heading_deg=_heading_deg(attitude),
        heading_reason=attitude.heading_reason or "it is not measured",
        seen=seen,
        rests=attitude.rests,
    )
    return (
        newest if newest.trouble or before.trouble or newest.epoch != before.epoch else _after(before, newest, settings)
    )


def not_known(heading: HeadingView, settings: DriveSettings, now: float, since: float = -inf) -> str:
    """Return why the base cannot turn by the attitude now, or an empty string; NaN in a comparison means that it
    cannot.

    An attitude at rest may be older before a turn; from the turn's start (`since`) it has the usual time to be renewed.
    """
    if heading.trouble:
        return heading.trouble
    oldest_s = (
        max(settings.attitude_max_age_s, RESTS_S) if heading.rests and since == -inf else settings.attitude_max_age_s
    )
    seen = max(heading.seen, since) if heading.rests else heading.seen
    return "" if now - seen <= oldest_s else f"the attitude is older than {oldest_s:g} s"


def shortest_deg(heading_deg: float, wanted_deg: float) -> float:
    """Return the shorter way from one heading to another, clockwise positive; clockwise if both are as long."""
    way_deg = (wanted_deg - heading_deg) % 360.0
    return way_deg if way_deg <= 180.0 else way_deg - 360.0


def _after(before: HeadingView, newest: HeadingView, settings: DriveSettings) -> HeadingView:
    elapsed_s = newest.seen - before.seen
    way_deg = newest.turned_deg - before.turned_deg
    most_deg = JUMP_DEG + JUMP_SHARE * settings.max_turn_dps * elapsed_s
    if not abs(way_deg) <= most_deg:
        return replace(newest, trouble=f"the attitude jumped by {way_deg:.0f} degrees within {elapsed_s:.2f} s")
    fastest_dps = JUMP_SHARE * settings.max_turn_dps
    turning_s = min(elapsed_s, BEGAN_S) if before.rests and not newest.rests else elapsed_s
    newest_dps = max(-fastest_dps, min(fastest_dps, way_deg / turning_s))
    rate_dps = before.rate_dps + (newest_dps - before.rate_dps) * SMOOTHING
    return replace(newest, rate_dps=rate_dps)


def _trouble(attitude: AttitudeState, turned_deg: float, seen: float) -> str:
    if not attitude.valid:
        return f"the attitude is not known: {attitude.reason or 'no reason given'}"
    if not (isfinite(turned_deg) and isfinite(seen)):
        return "the attitude makes no sense: it has no angle or no time"
    return ""


def _heading_deg(attitude: AttitudeState) -> float:
    heading_deg = nan if attitude.heading_deg is None else attitude.heading_deg
    return heading_deg if 0.0 <= heading_deg <= 360.0 else nan
