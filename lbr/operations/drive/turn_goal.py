"""Turning on the spot to a target: the power, the arrival, and a base that does not follow."""

from math import copysign, inf, isnan, nan, sqrt

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.codes import Reason
from lbr.messages.drive import HeadingCommand, TurnCommand
from lbr.operations.drive import heading_view
from lbr.operations.drive.heading_view import HeadingView
from lbr.operations.drive.settings import DriveSettings

QUIET_DPS = 3.0
"""The rate of turn below which the base counts as standing."""
RESTING_SHARE = 0.5
"""The tolerance for aiming a stop, as a share of the full tolerance."""
SWING_SHARE = 0.5
"""The reduction of power after each overshoot: a base that passed its target turns more than it should."""
MOVED_DEG = 1.0
AWAY_DEG = 5.0
COAST_S = 0.5
"""The base may move away from its target by `AWAY_DEG`, plus its turn in this time."""
PATIENCE_S = 0.3
"""The time without any turn after which the power of a correction begins to grow."""
GROWS_UNTIL = 0.8
"""The share of `turn_stuck_s` after which it has grown to that of a turn."""
GOOD_TRIES, MOST_WIDER = 3, 4.0
"""From the third correction on, each widens the tolerance by half of the original, up to this factor."""
GOOD_SWINGS, WIDER_PER_SWING = 1, 2
"""A base that overshoots more than once cannot turn by the small remainder: each overshoot widens the tolerance more.
"""
LEARNT_SHARE = 0.9


class Push(Struct, frozen=True, kw_only=True):
    """A push of the wheels to one side; for `idle_s`, without pauses, it moved the base less than a degree from
    `mark_deg`.

    For `still_s` the base stood, although recent power should have turned it.
    """

    sense: float
    mark_deg: float
    idle_s: float = 0.0
    still_s: float = 0.0


class TurnGoal(Struct, frozen=True, kw_only=True):
    """A turn in progress: from `begun_deg` by `asked_deg`, in degrees that the body has turned, clockwise positive.

    `quiet` is the time since which it stands at its target (NaN: it does not), `ends` the time limit. `flow_dps` is the
    rate of turn to expect from recent power. `farthest_deg` is the greatest allowed distance from the target now,
    `swings` the number of overshoots. `tries` counts pushes from rest. `least` is the power that a sticking base was
    seen to need, `given` its power now.
    """

    asked_deg: float
    begun_deg: float
    epoch: str
    heading: HeadingView
    ends: float
    allowed_s: float
    quiet: float = nan
    flow_dps: float = 0.0
    farthest_deg: float = inf
    swings: int = 0
    tries: int = 0
    least: float = 0.0
    given: float = 0.0
    push: Push | None = None

    @property
    def turned_deg(self) -> float:
        """Return the angle turned since its beginning."""
        return self.heading.turned_deg - self.begun_deg

    @property
    def left_deg(self) -> float:
        """Return the angle that remains."""
        return self.asked_deg - self.turned_deg


def not_possible(
    command: TurnCommand | HeadingCommand, heading: HeadingView, settings: DriveSettings, now: float
) -> Reason | None:
    """Return why the base cannot turn like this, or None."""
    if why := heading_view.not_known(heading, settings, now):
        return Reason("stale_sensor", why)
    if isinstance(command, HeadingCommand) and isnan(heading.heading_deg):
        return Reason("stale_sensor", f"the heading is not known: {heading.heading_reason}")
    return None


def start(command: TurnCommand | HeadingCommand, heading: HeadingView, settings: DriveSettings, now: float) -> TurnGoal:
    """Return a turn that begins now; to a heading it takes the shorter way from the current one."""
    asked_deg = (
        command.angle_deg
        if isinstance(command, TurnCommand)
        else heading_view.shortest_deg(heading.heading_deg, command.heading_deg)
    )
    power = min(settings.turn_power, settings.max_power)
    allowed_s = settings.turn_spare_s + 2.0 * abs(asked_deg) / (power * settings.max_turn_dps)
    return TurnGoal(
        asked_deg=asked_deg,
        begun_deg=heading.turned_deg,
        epoch=heading.epoch,
        heading=heading,
        ends=now + allowed_s,
        allowed_s=allowed_s,
        farthest_deg=_farthest_deg(abs(asked_deg), heading),
    )


def watch(turn: TurnGoal, heading: HeadingView, pushing: float, settings: DriveSettings) -> TurnGoal:
    """Return the turn after a new attitude, while the left wheel has the power `pushing`."""
    if heading.trouble or heading.epoch != turn.epoch:
        return replace(turn, heading=heading)
    elapsed_s = max(0.0, heading.seen - turn.heading.seen)
    before_deg, after_deg = turn.left_deg, turn.left_deg + turn.heading.turned_deg - heading.turned_deg
    passed = before_deg * after_deg < 0.0
    farthest_deg = _farthest_deg(abs(after_deg), heading)
    farthest_deg = farthest_deg if passed else min(farthest_deg, turn.farthest_deg)
    push, least = _push(turn, heading, pushing, elapsed_s), turn.least
    if _sticks(turn.push) and abs(heading.rate_dps) > QUIET_DPS:
        least = max(least, LEARNT_SHARE * abs(pushing))
    turn = replace(
        turn, heading=heading, push=push, least=least, farthest_deg=farthest_deg, swings=turn.swings + passed
    )
    still = abs(turn.left_deg) <= _tolerance_deg(turn, settings) and abs(heading.rate_dps) <= QUIET_DPS
    since = heading.seen if isnan(turn.quiet) else turn.quiet
    return replace(turn, quiet=since if still and pushing == 0.0 else nan)


def driven(turn: TurnGoal, left_power: float, elapsed_s: float, settings: DriveSettings) -> TurnGoal:
    """Return the turn after the left wheel had this power for a while."""
    share = min(1.0, elapsed_s / max(settings.turn_lag_s, 1e-3))
    flow_dps = turn.flow_dps + (left_power * settings.max_turn_dps - turn.flow_dps) * share
    from_rest = left_power != 0.0 and abs(turn.flow_dps) < QUIET_DPS / 2 and abs(turn.heading.rate_dps) <= QUIET_DPS
    return replace(turn, flow_dps=flow_dps, given=left_power, tries=turn.tries + from_rest)


def fault(turn: TurnGoal, settings: DriveSettings, now: float) -> Reason | None:
    """Return the fault of a turn, or None; with NaN in a comparison it is a fault."""
    heading = turn.heading
    if why := heading_view.not_known(heading, settings, now, since=turn.ends - turn.allowed_s):
        return Reason("stale_sensor", why)
    if heading.epoch != turn.epoch:
        return Reason("stale_sensor", "the attitude started over in the middle of the turn")
    if not now < turn.ends:
        return Reason("timeout", f"not within {turn.allowed_s:.1f} s: {words(turn)}")
    if not abs(turn.left_deg) <= turn.farthest_deg:
        return Reason(
            "not_followed",
            "the base turns away from its target: it is pushed, or the motors' or the inertial unit's signs are wrong",
        )
    return _without_effect(turn.push, heading, settings) if turn.push is not None else None


def is_over(turn: TurnGoal, settings: DriveSettings) -> bool:
    """Return whether the base has stood at its target for a while."""
    return turn.heading.seen - turn.quiet >= settings.turn_settle_s  # this way round, NaN is not over


def power(turn: TurnGoal, settings: DriveSettings, now: float) -> float:
    """Return the power now, clockwise positive: less near the target, zero where the base will come to rest."""
    rate_dps, left_deg = turn.heading.rate_dps, turn.left_deg
    highest = min(settings.turn_power, settings.max_power)
    age_s = min(max(0.0, now - turn.heading.seen), settings.attitude_max_age_s)
    flow_dps = rate_dps if _sticks(turn.push) and abs(rate_dps) <= QUIET_DPS else turn.flow_dps
    flow_dps *= 1.0 + SWING_SHARE * turn.swings
    faster_dps = max(rate_dps, flow_dps) if left_deg > 0.0 else min(rate_dps, flow_dps)
    rest_deg = left_deg - rate_dps * age_s - faster_dps * settings.turn_lag_s
    if abs(left_deg) <= _tolerance_deg(turn, settings) and abs(rate_dps) <= QUIET_DPS:
        return 0.0
    if min(rate_dps * copysign(1.0, left_deg), flow_dps * copysign(1.0, left_deg)) < -QUIET_DPS:
        return 0.0  # it comes to rest before it turns back, or it would swing
    if 0.0 < turn.given * copysign(1.0, left_deg) < turn.least and abs(rate_dps) <= QUIET_DPS:
        return copysign(min(highest, turn.least), left_deg)  # less would move nothing
    if not rest_deg * left_deg > 0.0 or abs(rest_deg) <= RESTING_SHARE * settings.turn_tolerance_deg:
        return 0.0  # this way round, NaN gives zero
    wished = sqrt(2.0 * settings.turn_brake_dps2 * abs(rest_deg)) / settings.max_turn_dps
    return copysign(min(highest, max(wished, _least(turn, settings))), left_deg)


def words(turn: TurnGoal) -> str:
    """Return a sentence about the angle turned."""
    return f"turned {turn.turned_deg:.1f} of {round(turn.asked_deg, 1):g} degrees"


def ended(turn: TurnGoal, elapsed_s: float) -> str:
    """Return a sentence about the end of a turn."""
    past_deg = -turn.left_deg if turn.asked_deg >= 0.0 else turn.left_deg
    how = "too far" if past_deg > 0.0 else "short"
    return f"{words(turn)} in {elapsed_s:.1f} s, {abs(past_deg):.1f} {how}"


def _push(turn: TurnGoal, heading: HeadingView, pushing: float, elapsed_s: float) -> Push | None:
    before, here_deg = turn.push, heading.turned_deg
    stands = abs(heading.rate_dps) <= QUIET_DPS
    if pushing == 0.0:
        waits = before is not None and stands and abs(turn.flow_dps) > QUIET_DPS
        return replace(before, still_s=before.still_s + elapsed_s) if before is not None and waits else before
    sense = copysign(1.0, pushing)
    if before is None or before.sense != sense or abs(here_deg - before.mark_deg) >= MOVED_DEG:
        return Push(sense=sense, mark_deg=here_deg)
    still_s = before.still_s + elapsed_s if stands else 0.0
    return replace(before, idle_s=before.idle_s + elapsed_s, still_s=still_s)


def _sticks(push: Push | None) -> bool:
    """Return whether the base stood although it was pushed for a while."""
    return push is not None and push.still_s > PATIENCE_S


def _tolerance_deg(turn: TurnGoal, settings: DriveSettings) -> float:
    """Return the tolerance, wider for a base that cannot turn by small angles."""
    steps = max(0, turn.tries - GOOD_TRIES, WIDER_PER_SWING * (turn.swings - GOOD_SWINGS))
    wider = min(MOST_WIDER, 1.0 + steps / 2)
    return settings.turn_tolerance_deg * wider


def _farthest_deg(left_deg: float, heading: HeadingView) -> float:
    return left_deg + AWAY_DEG + COAST_S * abs(heading.rate_dps)


def _without_effect(push: Push, heading: HeadingView, settings: DriveSettings) -> Reason | None:
    if push.idle_s < settings.turn_stuck_s:
        return None
    moved_deg = abs(heading.turned_deg - push.mark_deg)
    return Reason(
        "stuck", f"the base does not turn: {settings.turn_stuck_s:g} s of power turned it by {moved_deg:.1f} degrees"
    )


def _least(turn: TurnGoal, settings: DriveSettings) -> float:
    """Return the least power that turns the base, growing while it does not."""
    least = max(settings.turn_min_power, turn.least)
    still_s = 0.0 if turn.push is None else turn.push.still_s
    more = (still_s - PATIENCE_S) / max(GROWS_UNTIL * settings.turn_stuck_s - PATIENCE_S, 0.1)
    return least + max(0.0, settings.turn_power - least) * max(0.0, more)
