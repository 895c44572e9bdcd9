"""Range rules: the speed of the base towards the sights of its sensors. Rules only ever slow down."""

from collections.abc import Iterable, Mapping
from math import inf, isfinite, isnan, nan, sqrt
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.codes import Code
from lbr.messages.drive import Direction
from lbr.messages.motors import RESTS_S
from lbr.messages.sensing import Ranges, Scan
from lbr.operations.drive import sensors as sensing
from lbr.operations.drive.sensors import Sensors
from lbr.operations.drive.settings import DriveSettings, Rule

Blocker = Direction | Literal["memory"]
MEMORY: Literal["memory"] = "memory"

USUAL = sensing.sensors_of(DriveSettings())
JUMP_M = 0.3
PLAUSIBLE_MPS = 3.0
SPIN_SHARE = 0.15
TRACE_SHARE = 0.02
FROZEN_REPEATS = 2


class Odometer(Struct, frozen=True, kw_only=True):
    """The way of the base by its own estimate, forwards and backwards alike; turning at the wheels."""

    along_m: float = 0.0
    turned_m: float = 0.0

    def driven(self, left: float, right: float, dt_s: float, max_speed_mps: float, aside: float = 0.0) -> "Odometer":
        """Return the odometer after `dt_s` at these wheel powers; sideways counts as turning: side sensors see it."""
        step_m = dt_s * max_speed_mps / 2
        return Odometer(
            along_m=self.along_m + abs(left + right) * step_m,
            turned_m=self.turned_m + abs(left - right) * step_m + 2 * abs(aside) * step_m,
        )


class View(Struct, frozen=True, kw_only=True):
    """The belief about one sensor: `distance_m` is infinite when nothing is near, NaN when it is unknown.

    `pending_m` is a farther value that waits for a second one like it. `idle_m` is the distance driven while `raw_m`
    came `repeats` times in a row unchanged. `rests_until`: a change would have been reported at once until then.
    """

    distance_m: float
    trouble: str
    seen: float
    raw_m: float
    pending_m: float = nan
    changed_at_m: float = 0.0
    idle_m: float = 0.0
    repeats: int = 0
    rests_until: float = -inf


class Limit(Struct, frozen=True, kw_only=True):
    """The effect of the rules on a motion: both wheels times `scale`; 0 stops. `text` names sensor and distance.

    `code` distinguishes an obstacle from an unknown distance. `direction` is the rule's: that of the motion, or
    `memory` for a remembered obstacle.
    """

    scale: float = 1.0
    direction: Blocker | None = None
    text: str = ""
    detail: str = ""
    code: Code = "obstacle"
    blocked: tuple[Blocker, ...] = ()


FREE = Limit()


def measured_m(ranges: Ranges, sensor: str, sensors: Sensors = USUAL) -> tuple[float, str]:
    """Return a reading in metres (infinite: over range; NaN: none) and its error."""
    value = ranges.metres(sensor)
    status = ranges.status.get(sensor, "missing" if value is None else "ok")
    if status == "over_range":
        return inf, ""
    if status != "ok":
        return nan, status
    row = sensors.rows.get(sensor)
    if value is None or row is None or not 0.0 < value <= row.max_m:
        return nan, f"implausible ({value} m)"
    return value, ""


def see(
    views: Mapping[str, View], ranges: Ranges, now: float, odometer: Odometer, sensors: Sensors = USUAL
) -> dict[str, View]:
    """Return the beliefs about all sensors after new readings, with those about obstacles in the way."""
    updated, until = dict(views), now + RESTS_S if ranges.rests else -inf
    for name in sensors.singles:
        if not ranges.tells_of(name):
            continue
        row = sensors.rows[name]
        raw_m, trouble = measured = measured_m(ranges, name, sensors)
        travel_m = odometer.along_m if sensing.sees_along(row) else odometer.turned_m
        before = views.get(name)
        updated[name] = _see(before, measured, now, until, travel_m)
        same = before is not None and raw_m == before.raw_m and isfinite(raw_m)
        for view, side in sensors.covers(row):
            near_m = raw_m if isnan(raw_m) else sensing.single(sensors.ways[name][side], raw_m)
            travel_m = _travel_m(odometer, side)
            updated[view] = _see(views.get(view), (near_m, trouble), now, until, travel_m, same=same)
    return updated


def unchanged(views: Mapping[str, View], now: float) -> dict[str, View]:
    """Return the beliefs at the beginning of a motion, from which resting sensors have the usual time to report."""
    fresh = {name: view for name, view in views.items() if now <= view.rests_until}
    return {**views, **{name: replace(view, seen=now, rests_until=-inf) for name, view in fresh.items()}}


def see_scan(
    views: Mapping[str, View], scan: Scan, now: float, odometer: Odometer, sensors: Sensors, *, same: bool
) -> dict[str, View]:
    """Return the beliefs after a scan; `same`: it repeats the previous scan exactly."""
    updated = dict(views)
    for side, seen in sensing.scanned(sensors, sensors.rows[scan.sensor], scan).items():
        name = sensing.view_of(scan.sensor, side)
        updated[name] = _see(views.get(name), seen, now, -inf, _travel_m(odometer, side), same=same)
    return updated


def limit(
    settings: DriveSettings,
    views: Mapping[str, View],
    wheels: tuple[float, float],
    now: float,
    blocked: Iterable[Blocker] = (),
    aside: float = 0.0,
    *,
    rules: Iterable[Rule] | None = None,
) -> Limit:
    """Return the strictest limit on this motion of the wheels, and sideways to the left.

    `blocked` are the directions of stops in force; `rules` are the sensors' rules, by default the settings'.
    """
    parts = towards(*wheels, aside)
    held = frozenset(blocked)
    limits = [
        _apply(settings, rule, views, parts[rule.direction], now, held)
        for rule in (settings.rules if rules is None else rules)
    ]
    strictest = min(limits, key=lambda each: each.scale, default=FREE)
    stopped = tuple(each.direction for each in limits if each.direction is not None and not each.scale > 0.0)
    return replace(strictest, blocked=stopped)


def towards(left: float, right: float, aside: float = 0.0) -> dict[Direction, float]:
    """Return the part of a motion towards each side, as a fraction of full speed; `aside` goes to the left.

    Ahead and back count unless it is a spin. The sides count only in arcs and spins: an arc sweeps the side to which it
    curves, a spin both. So a base beside a wall can still drive along it and curve away from it.
    """
    ahead, turn = (left + right) / 2, (left - right) / 2
    whole = abs(ahead) + abs(turn)
    along = abs(ahead) > TRACE_SHARE * whole
    spin = abs(ahead) < SPIN_SHARE * whole
    side = abs(turn) if abs(turn) > SPIN_SHARE * whole else 0.0
    return {
        "forward": max(0.0, ahead) if along else 0.0,
        "back": max(0.0, -ahead) if along else 0.0,
        "right": max(side if spin or ahead * turn > 0.0 else 0.0, -aside),
        "left": max(side if spin or ahead * turn < 0.0 else 0.0, aside),
    }


def allowed_mps(room_m: float, settings: DriveSettings) -> float:
    """Return the speed from which the base still stops within `room_m`, reaction included; 0 when there is no room."""
    if not room_m > 0.0:  # this way round, NaN means stop
        return 0.0
    reaction_s, brake = settings.reaction_s, settings.brake_mps2
    return max(0.0, brake * (sqrt(reaction_s**2 + 2 * room_m / brake) - reaction_s))


def _apply(
    settings: DriveSettings,
    rule: Rule,
    views: Mapping[str, View],
    part: float,
    now: float,
    held: frozenset[Blocker],
) -> Limit:
    if part <= 0.0:
        return FREE
    distance_m, trouble = believed(views.get(rule.sensor), rule, now)
    keep_m = rule.stop_m + (rule.margin_m if rule.direction in held else 0.0)
    share = allowed_mps(distance_m - keep_m, settings) / settings.max_speed_mps
    scale = share / part
    if scale >= 1.0:
        return FREE
    text = f"{rule.sensor} {trouble}" if trouble else f"{rule.sensor} {distance_m:.2f} m"
    return Limit(
        scale=max(0.0, scale),
        direction=rule.direction,
        text=text,
        detail=text if trouble else f"{text} is inside {keep_m:.2f} m",
        code="stale_sensor" if trouble else "obstacle",
    )


def believed(view: View | None, rule: Rule, now: float) -> tuple[float, str]:
    """Return the distance for a rule, infinite for nothing near, or NaN and why it is unknown."""
    if view is None:
        return nan, "was never measured"
    if not now - view.seen <= rule.max_age_s:
        return nan, f"reading is older than {rule.max_age_s:g} s"
    if view.trouble:
        return nan, f"reading is {view.trouble}"
    if view.repeats >= FROZEN_REPEATS and view.idle_m > rule.frozen_after_m:
        return nan, f"reading is frozen at {view.raw_m:.2f} m" if isfinite(view.raw_m) else "reading is frozen"
    return view.distance_m, ""


def _see(
    view: View | None, raw: tuple[float, str], now: float, until: float, travel_m: float, *, same: bool | None = None
) -> View:
    """Return the belief after a value; `same` is whether the sensor repeats itself, by default by comparison."""
    raw_m, trouble = raw
    if view is not None and now < view.seen:
        return view  # a newer one has overtaken it
    if view is None or isnan(raw_m):
        return View(distance_m=raw_m, trouble=trouble, seen=now, raw_m=raw_m, changed_at_m=travel_m, rests_until=until)
    distance_m, pending_m = _trust(view, raw_m, now - view.seen)
    same = raw_m == view.raw_m and isfinite(raw_m) if same is None else same
    since_m = view.changed_at_m if same else travel_m
    return View(
        distance_m=distance_m,
        trouble="",
        seen=now,
        raw_m=raw_m,
        pending_m=pending_m,
        changed_at_m=since_m,
        idle_m=travel_m - since_m,
        repeats=view.repeats + 1 if same else 0,
        rests_until=until,
    )


def _travel_m(odometer: Odometer, side: Direction) -> float:
    return odometer.along_m if side in {"forward", "back"} else odometer.turned_m


def _trust(view: View, raw_m: float, dt_s: float) -> tuple[float, float]:
    """Accept a nearer value at once, a much farther one only when a second reading confirms it."""
    step_m = JUMP_M + PLAUSIBLE_MPS * max(0.0, dt_s)
    first = isnan(view.distance_m)
    if first or raw_m <= view.distance_m + step_m or raw_m >= view.pending_m - step_m:
        return raw_m, nan
    return view.distance_m, raw_m
