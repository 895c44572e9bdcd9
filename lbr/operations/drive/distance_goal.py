"""Driving a distance by the wheels: the speed near its end, the arrival, and wheels that do not follow."""

from math import cos, inf, isnan, nan, radians

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand
from lbr.operations.drive import odometry_view
from lbr.operations.drive.command import straight
from lbr.operations.drive.odometry_view import OdometryView
from lbr.operations.drive.rules import allowed_mps
from lbr.operations.drive.settings import DriveSettings

STANDING_MPS = 0.03
SETTLE_S = 0.2
WRONG_M = 0.15


class DistanceGoal(Struct, frozen=True, kw_only=True):
    """A distance in progress: `asked_m` from `begun_m`, towards `sense` (1 ahead, -1 back).

    `quiet` is the time since which the base stands at its end (NaN: it does not). `backward_m` is the distance that it
    may roll the other way at first. `slipped` is true once a slip was reported.
    """

    asked_m: float
    sense: float
    begun_m: float
    epoch: str
    odometry: OdometryView
    backward_m: float
    quiet: float = nan
    slipped: bool = False

    @property
    def travelled_m(self) -> float:
        """Return the distance travelled towards its end."""
        return self.sense * (self.odometry.distance_m - self.begun_m)

    @property
    def left_m(self) -> float:
        """Return the distance that remains."""
        return self.asked_m - self.travelled_m


def not_possible(command: DriveCommand, odometry: OdometryView, now: float) -> Reason | None:
    """Return why this distance cannot be driven, or None."""
    if not command.distance_cm > 0.0:
        return None
    if not straight(command):
        why = f"distance_cm goes straight ahead or back only (angle_deg 0 or 180), not {command.angle_deg:g}"
        return Reason("bad_value", why)
    why = odometry_view.not_known(odometry, now)
    return Reason("stale_sensor", f"no distance can be driven: {why}") if why else None


def start(command: DriveCommand, odometry: OdometryView, settings: DriveSettings) -> DistanceGoal:
    """Return the goal that a command begins."""
    sense = 1.0 if cos(radians(command.angle_deg)) > 0.0 else -1.0
    speed = abs(odometry.speed_mps)
    rolls_m = speed * settings.reaction_s + speed * speed / (2 * settings.brake_mps2)
    return DistanceGoal(
        asked_m=command.distance_cm / 100,
        sense=sense,
        begun_m=odometry.distance_m,
        epoch=odometry.epoch,
        odometry=odometry,
        backward_m=WRONG_M + rolls_m,
    )


def watch(way: DistanceGoal, odometry: OdometryView, pushing: float, settings: DriveSettings) -> DistanceGoal:
    """Return the goal after new odometry, while the wheels have the power `pushing`.

    Odometry that comes to rest has stood for longer than `SETTLE_S`, and its next message comes late.
    """
    if odometry.trouble or odometry.epoch != way.epoch:
        return replace(way, odometry=odometry)
    rested = odometry.rests and not way.odometry.rests
    way = replace(way, odometry=odometry)
    still = way.left_m <= settings.distance_tolerance_m and abs(odometry.speed_mps) <= STANDING_MPS
    since = -inf if rested else odometry.seen if isnan(way.quiet) else way.quiet
    return replace(way, quiet=since if still and pushing == 0.0 else nan)


def fault(way: DistanceGoal, started: float, now: float) -> Reason | None:
    """Return the fault of a goal, or None; with NaN in a comparison it is a fault."""
    if why := odometry_view.not_known(way.odometry, now, started):
        return Reason("stale_sensor", why)
    if way.odometry.epoch != way.epoch:
        return Reason("stale_sensor", "the odometry started over on the way")
    if way.odometry.stalled:
        return Reason("stuck", "the wheels stand although the motors push")
    if not way.travelled_m > -way.backward_m:
        why = "the wheels turn the other way: look at the motors' and the encoders' signs"
        return Reason("not_followed", why)
    return None


def is_over(way: DistanceGoal) -> bool:
    """Return whether the base has stood at the end for a while."""
    return way.odometry.seen - way.quiet >= SETTLE_S  # this way round, NaN is not over


def power(way: DistanceGoal, asked: float, settings: DriveSettings, now: float) -> float:
    """Return the power now, `asked` at most: less near the end, zero where the base will come to rest."""
    lag_s = max(0.0, now - way.odometry.seen)
    ahead_mps = max(0.0, way.sense * way.odometry.speed_mps)
    left_m = way.left_m - ahead_mps * lag_s
    if not left_m > ahead_mps * ahead_mps / (2 * settings.brake_mps2) + settings.distance_tolerance_m / 2:
        return 0.0  # this way round, NaN gives zero
    wished = allowed_mps(left_m, settings) / settings.max_speed_mps
    return min(asked, max(wished, settings.creep_power))


def words(way: DistanceGoal) -> str:
    """Return a sentence about the distance driven."""
    return f"drove {way.travelled_m:.2f} of {way.asked_m:.4g} m"


def ended(way: DistanceGoal, elapsed_s: float) -> str:
    """Return a sentence about the end of a goal."""
    past_m = -way.left_m
    return f"{words(way)} in {elapsed_s:.1f} s, {abs(past_m):.2f} m {'too far' if past_m > 0.0 else 'short'}"
