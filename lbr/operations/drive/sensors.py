"""The base's range sensors: which can see an obstacle in the way of a motion, and its distance.

An obstacle is in the way of a motion towards one side if it lies beyond the outline there. It may be at most `ASIDE_M`
further aside than the outline. Its distance is that from the outline.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from math import ceil, cos, inf, isnan, nan, pi, sin, tau
from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.drive import Direction
from lbr.messages.sensing import RING, RangeSensor, Scan, ring
from lbr.operations.drive.settings import DriveSettings, Rule

ASIDE_M = 0.05
"""The sideways error of a base after a metre with a heading error of three degrees."""
BLIND_RAD = 0.1
"""The widest part of a scan that may be unknown: at half a metre, a leg of five centimetres hides in it."""
LOOK_RAD = 0.02
SPREAD_RAD = 0.05
LEAST_M = 0.01
FROZEN_AFTER_M: Mapping[Direction, float] = {"forward": 0.10, "back": 0.10, "left": 0.30, "right": 0.30}
SIDES: Mapping[Direction, float] = {"forward": 0.0, "back": pi, "left": pi / 2, "right": -pi / 2}
NOT_PLAUSIBLE = "not plausible"

Seen = tuple[float, str]
"""A distance (infinite: nothing; NaN: unknown) and its error."""


class Ray(NamedTuple):
    """The part of a ray in which an obstacle is in the way, at start + slope * distance from the outline."""

    number: int
    enters_m: float
    leaves_m: float
    start_m: float
    slope: float

    def outside_m(self, along_m: float) -> float:
        """Return the distance of an obstacle from the outline."""
        return max(0.0, self.start_m + along_m * self.slope)


class Way(Struct, frozen=True):
    """The rays of a sensor that meet obstacles on one side, and groups of which one ray each must be known."""

    rays: tuple[Ray, ...]
    looks: tuple[tuple[int, ...], ...] = ()


class Sensors(Struct, frozen=True, kw_only=True):
    """The sensors of a base of this size. `rules` are the drive's own, and those from rows."""

    rows: Mapping[str, RangeSensor]
    length_m: float
    width_m: float
    ways: Mapping[str, Mapping[Direction, Way]]
    rules: tuple[Rule, ...]

    @property
    def watched(self) -> Mapping[str, Rule]:
        """The rules of sensors with views of their own, by view."""
        return {rule.sensor: rule for rule in self.rules if " " in rule.sensor}

    @property
    def singles(self) -> tuple[str, ...]:
        """The names of the sensors with a single distance."""
        order = (*RING, *self.rows)
        return tuple(sorted((name for name, row in self.rows.items() if row.rays == 1), key=order.index))

    def covers(self, row: RangeSensor) -> Iterable[tuple[str, Direction]]:
        """Yield the views of a sensor: name and side."""
        return ((view_of(row.name, side), side) for side in self.ways.get(row.name, ()))


def view_of(sensor: str, side: Direction) -> str:
    """Return the name of a sensor's view on one side; rows have no blank in their names."""
    return f"{sensor} {side}"


def sensors_of(settings: DriveSettings, rows: Iterable[RangeSensor] | None = None) -> Sensors:
    """Return the sensors of a base; without rows, a ring around its outline."""
    size = settings.body_length_m, settings.body_width_m
    known = {row.name: row for row in sorted(ring(*size) if rows is None else rows, key=_ring_first)}
    named = {one.sensor for one in settings.rules}
    ways = {
        row.name: _ways(row, *size)
        for row in known.values()
        if row.level and (row.stop_m is not None or (row.rays > 1 and row.name in named))
    }
    own = tuple(_named(rule, known) for rule in settings.rules)
    ruled = {(rule.sensor.partition(" ")[0], rule.direction) for rule in own}
    made = tuple(
        Rule(direction=side, sensor=view_of(name, side), stop_m=stop_m, frozen_after_m=FROZEN_AFTER_M[side])
        for name, of_sensor in ways.items()
        if (stop_m := known[name].stop_m) is not None
        for side in of_sensor
        if (name, side) not in ruled
    )
    return Sensors(rows=known, length_m=size[0], width_m=size[1], ways=ways, rules=(*own, *made))


def sees_along(row: RangeSensor) -> bool:
    """Return whether a sensor's reading changes by driving, rather than by turning."""
    return not row.level or abs(cos(row.yaw_rad)) > abs(sin(row.yaw_rad))


def single(way: Way, raw_m: float) -> float:
    """Return the distance of an obstacle from the outline, for a sensor with one distance: it may be anywhere in the
    cone."""
    found = [ray.outside_m(raw_m) for ray in way.rays if ray.enters_m <= raw_m <= ray.leaves_m]
    if found:
        return min(found)
    return 0.0 if raw_m < min(ray.enters_m for ray in way.rays) else inf


def scanned(sensors: Sensors, row: RangeSensor, scan: Scan) -> dict[Direction, Seen]:
    """Return the obstacles in a scan, for each side that the sensor watches."""
    watched = sensors.ways.get(row.name, {})
    if not plausible(scan):
        return dict.fromkeys(watched, (nan, NOT_PLAUSIBLE))
    count, step, metres = len(scan.ranges_m), scan.angle_increment_rad, scan.metres()
    seen_by = _crossed(row, scan.angle_min_rad, step, count, sensors.length_m, sensors.width_m)
    return {side: _scanned(seen_by[side], metres, scan.range_min_m) for side in watched}


def plausible(scan: Scan) -> bool:
    """Return whether the angles and limits of a scan are possible: at least two rays, and no more than once around."""
    count, step = len(scan.ranges_m), abs(scan.angle_increment_rad)
    turns = count > 1 and 0.0 < step * (count - 1) <= tau and abs(scan.angle_min_rad) <= tau
    return turns and 0.0 <= scan.range_min_m < scan.range_max_m


def _named(rule: Rule, rows: Mapping[str, RangeSensor]) -> Rule:
    row = rows.get(rule.sensor)
    return rule if row is None or row.rays == 1 else replace(rule, sensor=view_of(rule.sensor, rule.direction))


def _ring_first(row: RangeSensor) -> tuple[int, str]:
    order = ("forward", "left", "back", "right", "bottom")
    return (order.index(row.name) if row.name in order else len(order)), row.name


def _ways(row: RangeSensor, length_m: float, width_m: float) -> dict[Direction, Way]:
    """Return the ways that a sensor watches, by its row."""
    if row.rays > 1:
        found = _crossed(row, row.first_rad, row.step_rad, row.rays, length_m, width_m)
        return {side: way for side, way in found.items() if way.looks}
    angles = _spread(row.fov_rad, SPREAD_RAD)
    rays = {side: _rays(row, angles, side, length_m, width_m) for side in SIDES}
    return {side: Way(of_side) for side, of_side in rays.items() if of_side}


@lru_cache(maxsize=32)
def _crossed(
    row: RangeSensor, first_rad: float, step_rad: float, count: int, length_m: float, width_m: float
) -> Mapping[Direction, Way]:
    """Return for each side the rays of such a scan, and the groups in which its row expects a look."""
    angles = [first_rad + number * step_rad for number in range(count)]
    looks = _spread(row.fov_rad, LOOK_RAD)
    about_rad = max((BLIND_RAD - LOOK_RAD) / 2, 0.6 * row.step_rad)  # as sparse as its row allows
    ways: dict[Direction, Way] = {}
    for side in SIDES:
        wanted = [looks[ray.number] for ray in _rays(row, looks, side, length_m, width_m)]
        near = (tuple(n for n, angle in enumerate(angles) if _apart(angle, look) <= about_rad) for look in wanted)
        ways[side] = Way(_rays(row, angles, side, length_m, width_m), tuple(near))
    return ways


def _scanned(way: Way, metres: Sequence[float], least_m: float) -> Seen:
    nearest_m, hidden = inf, set()
    for ray in way.rays:
        value = metres[ray.number]
        if value == -inf and ray.enters_m <= least_m:
            value = ray.enters_m
        if value < ray.enters_m:  # the base itself, or its load
            hidden.add(ray.number)
        elif value <= ray.leaves_m:
            nearest_m = min(nearest_m, ray.outside_m(value))
    for group in way.looks:
        if all(isnan(metres[number]) or number in hidden for number in group):
            return nan, "missing"
    return nearest_m, ""


def _rays(
    row: RangeSensor, angles: Sequence[float], side: Direction, length_m: float, width_m: float
) -> tuple[Ray, ...]:
    found = (_ray(row, number, angle, side, length_m, width_m) for number, angle in enumerate(angles))
    return tuple(ray for ray in found if ray is not None)


def _ray(row: RangeSensor, number: int, angle: float, side: Direction, length_m: float, width_m: float) -> Ray | None:
    """Return the part of a ray in the way on one side, in axes of that side: beyond the outline and not far aside."""
    c, s = round(cos(SIDES[side])), round(sin(SIDES[side]))
    ahead_m, aside_m = row.x_m * c + row.y_m * s, row.y_m * c - row.x_m * s
    half_m, wide_m = (length_m / 2, width_m / 2) if c else (width_m / 2, length_m / 2)
    looks = row.yaw_rad + angle - SIDES[side]
    ahead, aside = cos(looks), sin(looks)
    bounds = (
        _beyond(half_m - ahead_m, ahead),
        _beyond(-wide_m - ASIDE_M - aside_m, aside),
        _beyond(-wide_m - ASIDE_M + aside_m, -aside),
    )
    enters_m, leaves_m = max(low for low, _ in bounds), min(high for _, high in bounds)
    if not (leaves_m - enters_m >= LEAST_M and enters_m < row.max_m):
        return None
    return Ray(number, enters_m, leaves_m, ahead_m - half_m, ahead)


def _beyond(edge_m: float, slope: float) -> tuple[float, float]:
    """Return the distances between which a ray that gains `slope` is beyond an edge."""
    if abs(slope) < 1e-9:
        return (0.0, inf) if edge_m <= 0.0 else (inf, -inf)
    at_m = edge_m / slope
    return (max(0.0, at_m), inf) if slope > 0.0 else (0.0, at_m)


def _spread(fov_rad: float, step_rad: float) -> tuple[float, ...]:
    count = max(2, ceil(fov_rad / step_rad))
    return tuple(-fov_rad / 2 + number * fov_rad / count for number in range(count + 1))


def _apart(one: float, other: float) -> float:
    return abs((one - other + pi) % tau - pi)
