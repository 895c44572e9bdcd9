"""A memory of seen obstacles: it keeps arcs and spins from obstacles outside the sensors' cones."""

from collections.abc import Iterable, Mapping, Sequence
from math import atan2, cos, hypot, inf, isnan, pi, radians, sin, tau
from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.drive import Direction
from lbr.messages.sensing import RangeSensor, Scan
from lbr.operations.drive import sensors as sensing
from lbr.operations.drive.footprint import Footprint
from lbr.operations.drive.heading_view import HeadingView
from lbr.operations.drive.odometry_view import OdometryView
from lbr.operations.drive.rules import FREE, MEMORY, USUAL, Blocker, Limit, View, allowed_mps, towards
from lbr.operations.drive.sensors import Sensors
from lbr.operations.drive.settings import DriveSettings

MOST_SPOTS = 40
ACROSS = (-1.0, -0.5, 0.0, 0.5, 1.0)
SECTOR_RAD = pi / 36
"""The width of a sector around the base, of which a scan leaves the nearest spot."""
SURE_SHARE = 0.8
"""The part of a cone in which no obstacle is missed."""
BEYOND_M = 0.15
"""A spot is dropped when its sensor sees this much farther; a nearer spot is too near for the sensor to see."""
APART_M = 0.06
LEAST_M = 0.02
"""The shortest way that counts: by its own estimate alone the base would creep up to an obstacle forever."""
STILL_M, STILL_RAD = 0.01, 0.01
WORDS: dict[Direction, str] = {"forward": "ahead", "back": "behind", "left": "on the left", "right": "on the right"}


class Spot(NamedTuple):
    """The place of an obstacle, and the time it was seen: x ahead, y left, from the middle of the base (REP 103).

    `by` is the sensor that saw it, until the base moves. Only its own `scanner` can clear the spot of a scan: other
    sensors look at other heights.
    """

    x_m: float
    y_m: float
    seen: float
    by: str | None = None
    scanner: str | None = None


class ObstacleMemory(Struct, frozen=True, kw_only=True):
    """The obstacles around the base at the last reading of its sensors, and the way of the base since then.

    `turned_rad` and `way_m` are the parts of that way known from the wheels' powers only; attitude and odometry correct
    them.
    """

    spots: tuple[Spot, ...] = ()
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    turned_rad: float = 0.0
    way_m: float = 0.0


class Ahead(Struct, frozen=True, kw_only=True):
    """The first obstacle of a motion: after `way_m` of its faster wheel (infinite: no obstacle), and its place now."""

    way_m: float = inf
    side: Direction = "forward"
    distance_m: float = inf


NOTHING = Ahead()


def moved(
    memory: ObstacleMemory, left: float, right: float, dt_s: float, settings: DriveSettings, aside: float = 0.0
) -> ObstacleMemory:
    """Return the memory of a base whose wheels had these powers for a while."""
    if not memory.spots:
        return memory
    step_m = settings.max_speed_mps * dt_s
    turn_rad, way_m = (right - left) * step_m / settings.track_m, (left + right) * step_m / 2
    return replace(
        _shifted(memory, way_m, turn_rad, aside * step_m),
        turned_rad=memory.turned_rad + turn_rad,
        way_m=memory.way_m + way_m,
    )


def turned(memory: ObstacleMemory, before: HeadingView, after: HeadingView) -> ObstacleMemory:
    """Return the memory with the turn from the attitude in place of that from the wheels."""
    if after is before:
        return memory
    turn_rad = memory.turned_rad
    if not (before.trouble or after.trouble) and before.epoch == after.epoch:
        turn_rad = radians(before.turned_deg - after.turned_deg)
    return replace(memory, yaw_rad=memory.yaw_rad + turn_rad - memory.turned_rad, turned_rad=0.0)


def drove(memory: ObstacleMemory, before: OdometryView, after: OdometryView) -> ObstacleMemory:
    """Return the memory with the way from the odometry in place of that from the wheels."""
    if after is before:
        return memory
    way_m = memory.way_m
    if not (before.trouble or after.trouble) and before.epoch == after.epoch:
        way_m = after.distance_m - before.distance_m
    return replace(_shifted(memory, way_m - memory.way_m, 0.0), way_m=0.0)


def see(
    memory: ObstacleMemory, views: Mapping[str, View], now: float, settings: DriveSettings, sensors: Sensors = USUAL
) -> ObstacleMemory:
    """Return the memory after new readings; only those of this moment count, and a missing reading clears nothing."""
    if not settings.memory_s > 0.0:
        return ObstacleMemory()
    stands = hypot(memory.x_m, memory.y_m) < STILL_M and abs(memory.yaw_rad) < STILL_RAD
    known = memory.spots if stands else around(memory)
    spots = _not_forgotten(known, now, settings)
    for name, row in sensors.rows.items():
        view = views.get(name)
        if row.rays == 1 and row.level and view is not None and view.seen == now and not isnan(view.raw_m):
            spots = _seen(spots, view, row, settings)
    return _with(memory, spots, stands=stands)


def see_scan(
    memory: ObstacleMemory, row: RangeSensor, scan: Scan, now: float, settings: DriveSettings
) -> ObstacleMemory:
    """Return the memory after a scan: with the spots that it hits, without those that it looks past."""
    if not settings.memory_s > 0.0 or not sensing.plausible(scan):
        return memory
    stands = hypot(memory.x_m, memory.y_m) < STILL_M and abs(memory.yaw_rad) < STILL_RAD
    known = memory.spots if stands else around(memory)
    metres = scan.metres()
    remembered = [spot for spot in _not_forgotten(known, now, settings) if not _passed(spot, row, scan, metres)]
    by_sector: dict[int, tuple[float, Spot]] = {}
    reach_m = settings.memory_reach_m + settings.body_length_m / 2
    for number, value_m in enumerate(metres):
        if 0.0 <= value_m < reach_m:  # this way round, NaN is no place
            angle = row.yaw_rad + scan.angle_min_rad + number * scan.angle_increment_rad
            spot = Spot(row.x_m + value_m * cos(angle), row.y_m + value_m * sin(angle), now, row.name, row.name)
            sector, away_m = round(atan2(spot.y_m, spot.x_m) / SECTOR_RAD), hypot(spot.x_m, spot.y_m)
            if away_m < by_sector.get(sector, (inf, spot))[0]:
                by_sector[sector] = away_m, spot
    return _with(memory, [*remembered, *(spot for _, spot in by_sector.values())], stands=stands)


def _with(memory: ObstacleMemory, spots: list[Spot], *, stands: bool) -> ObstacleMemory:
    nearest = tuple(sorted(spots, key=lambda spot: hypot(spot.x_m, spot.y_m))[:MOST_SPOTS])
    if stands:
        return replace(memory, spots=nearest)
    return replace(memory, spots=nearest, x_m=0.0, y_m=0.0, yaw_rad=0.0)


def redated(memory: ObstacleMemory, now: float) -> ObstacleMemory:
    """Return the memory on a clock that starts over: all spots count as seen just now."""
    return replace(memory, spots=tuple(spot._replace(seen=now) for spot in memory.spots))


def around(memory: ObstacleMemory) -> list[Spot]:
    """Return the remembered spots, relative to the base now."""
    return [
        Spot(*place, spot.seen, None, spot.scanner) for place, spot in zip(_places(memory), memory.spots, strict=True)
    ]


def limit(
    memory: ObstacleMemory,
    settings: DriveSettings,
    wheels: tuple[float, float],
    now: float,
    blocked: Iterable[Blocker] = (),
    aside: float = 0.0,
) -> Limit:
    """Return the memory's limit on a motion of the wheels, and sideways to the left.

    A stop is held until there is some more room.
    """
    if not (memory.spots and settings.memory_s > 0.0):
        return FREE
    memory = replace(memory, spots=tuple(_not_forgotten(memory.spots, now, settings)))
    arc = _limit(ahead(memory, wheels, settings), max(map(abs, wheels)), settings, blocked) if sweeps(wheels) else FREE
    if aside == 0.0:
        return arc
    way = (wheels[0] + wheels[1]) / 2, aside
    shift = _limit(_beside(memory, way, settings), hypot(*way), settings, blocked)
    return min(arc, shift, key=lambda each: each.scale)


def _limit(obstacle: Ahead, speed: float, settings: DriveSettings, blocked: Iterable[Blocker]) -> Limit:
    keep_m = settings.memory_stop_m + (settings.memory_hold_m if MEMORY in blocked else 0.0)
    room_m = obstacle.way_m - keep_m
    share = allowed_mps(room_m, settings) / settings.max_speed_mps if room_m > LEAST_M else 0.0
    scale = min(1.0, share / speed)
    if scale >= 1.0:
        return FREE
    text = f"something remembered {WORDS[obstacle.side]} at {obstacle.distance_m:.2f} m"
    stopped = () if scale > 0.0 else (MEMORY,)
    return Limit(scale=scale, direction=MEMORY, text=text, detail=text, blocked=stopped)


def sweeps(wheels: tuple[float, float]) -> bool:
    """Return whether a motion is an arc or a spin; straight ahead and behind only the live rules apply."""
    parts = towards(*wheels)
    return parts["left"] > 0.0 or parts["right"] > 0.0


def ahead(memory: ObstacleMemory, wheels: tuple[float, float], settings: DriveSettings) -> Ahead:
    """Return the first obstacle of an arc or a spin; one to the right is computed in a mirror."""
    left, right = wheels
    mirror = 1.0 if right > left else -1.0
    slower, faster = (left, right) if right > left else (right, left)
    if not memory.spots or not faster > slower:
        return NOTHING
    half_m = settings.track_m / 2
    radius_m = half_m * (faster + slower) / (faster - slower)
    footprint = Footprint(settings.body_length_m / 2, settings.body_width_m / 2, settings.memory_margin_m, radius_m)
    turn_rad, x_m, y_m = min([(footprint.until_rad(x_m, mirror * y_m), x_m, y_m) for x_m, y_m in _places(memory)])
    if turn_rad == inf:
        return NOTHING
    side, distance_m = _named(x_m, y_m, settings)
    return Ahead(way_m=turn_rad * (abs(radius_m) + half_m), side=side, distance_m=distance_m)


def _beside(memory: ObstacleMemory, way: tuple[float, float], settings: DriveSettings) -> Ahead:
    """Return the first obstacle of a straight motion, ahead and to the left."""
    reach_m = (
        settings.body_length_m / 2 + settings.memory_margin_m,
        settings.body_width_m / 2 + settings.memory_margin_m,
    )
    nearest = NOTHING
    for x_m, y_m in _places(memory):
        way_m = _until_m((x_m, y_m), way, reach_m)
        if way_m < nearest.way_m:
            side, distance_m = _named(x_m, y_m, settings)
            nearest = Ahead(way_m=way_m, side=side, distance_m=distance_m)
    return nearest


def _until_m(spot: tuple[float, float], way: tuple[float, float], reach_m: tuple[float, float]) -> float:
    """Return the way of a rectangle until a spot is in it; infinite if it never is, or the rectangle moves away."""
    speed, first, last = hypot(*way), -inf, inf
    for at_m, part, half_m in zip(spot, way, reach_m, strict=True):
        if part == 0.0:
            if abs(at_m) >= half_m:
                return inf
            continue
        ends = sorted(((at_m - half_m) * speed / part, (at_m + half_m) * speed / part))
        first, last = max(first, ends[0]), min(last, ends[1])
    if not first < last or last <= 0.0:
        return inf
    if first > 0.0:
        return first
    nearer = spot[0] * way[0] + spot[1] * way[1] > 0.0
    return 0.0 if nearer else inf


def _not_forgotten(spots: Iterable[Spot], now: float, settings: DriveSettings) -> list[Spot]:
    return [spot for spot in spots if not now - spot.seen >= settings.memory_s]  # this way round, NaN forgets nothing


def _places(memory: ObstacleMemory) -> list[tuple[float, float]]:
    c, s = cos(memory.yaw_rad), sin(memory.yaw_rad)
    x0_m, y0_m = c * memory.x_m + s * memory.y_m, c * memory.y_m - s * memory.x_m
    return [(c * x_m + s * y_m - x0_m, c * y_m - s * x_m - y0_m) for x_m, y_m, *_ in memory.spots]


def _shifted(memory: ObstacleMemory, way_m: float, turn_rad: float, aside_m: float = 0.0) -> ObstacleMemory:
    looks = memory.yaw_rad + turn_rad / 2
    x_m = memory.x_m + way_m * cos(looks) - aside_m * sin(looks)
    y_m = memory.y_m + way_m * sin(looks) + aside_m * cos(looks)
    return replace(memory, x_m=x_m, y_m=y_m, yaw_rad=memory.yaw_rad + turn_rad)


def _seen(spots: list[Spot], view: View, row: RangeSensor, settings: DriveSettings) -> list[Spot]:
    """Return the spots after a reading: without those that the sensor looks past, and with new near ones.

    An obstacle may be anywhere across its cone, and extend beyond it. New spots replace old ones beside them.
    """
    c, s, near_m = cos(row.yaw_rad), sin(row.yaw_rad), view.raw_m
    face_m, off_m = round(row.x_m * c + row.y_m * s, 9), round(row.y_m * c - row.x_m * s, 9)
    clear_m = min(near_m, view.distance_m) - BEYOND_M  # a farther value counts once a second one confirms it
    half_m = max(near_m * sin(row.fov_rad / 2), settings.memory_aside_m)
    across = [part * half_m for part in ACROSS] if near_m < settings.memory_reach_m else []
    remaining = []
    for spot in spots:
        along_m, across_m = spot[0] * c + spot[1] * s - face_m, spot[1] * c - spot[0] * s - off_m
        if clear_m > 0.0 and _past(spot, row, along_m, across_m, clear_m):
            continue
        if abs(along_m - near_m) >= APART_M or not any(abs(across_m - aside_m) < APART_M for aside_m in across):
            remaining.append(spot)
    far_m = face_m + near_m
    beside = [aside + off_m for aside in across]
    return remaining + [Spot(far_m * c - aside * s, far_m * s + aside * c, view.seen, row.name) for aside in beside]


def _passed(spot: Spot, row: RangeSensor, scan: Scan, metres: Sequence[float]) -> bool:
    """Return whether a scan looks past a spot of an earlier scan, or sees it again."""
    if spot.scanner != row.name:
        return False
    x_m, y_m, step = spot.x_m - row.x_m, spot.y_m - row.y_m, scan.angle_increment_rad
    turn = atan2(y_m, x_m) - row.yaw_rad - scan.angle_min_rad
    number = round(((turn if step > 0.0 else -turn) % tau) / abs(step))
    number = 0 if number >= len(metres) and number == round(tau / abs(step)) else number
    if number >= len(metres) or isnan(metres[number]):
        return False
    farther_m = metres[number] - hypot(x_m, y_m)
    return farther_m > BEYOND_M or abs(farther_m) < APART_M


def _past(spot: Spot, row: RangeSensor, along_m: float, across_m: float, clear_m: float) -> bool:
    """Return whether a sensor sees past a spot: by its cone, or past a spot of its own from this position."""
    if spot.scanner is not None:
        return False
    if spot.by == row.name:
        return along_m < clear_m
    in_sight = along_m > BEYOND_M and abs(across_m) < SURE_SHARE * row.fov_rad / 2 * along_m
    return in_sight and hypot(along_m, across_m) < clear_m


def _named(x_m: float, y_m: float, settings: DriveSettings) -> tuple[Direction, float]:
    """Return the side of the base on which a point is, and its distance from the outline."""
    out_x, out_y = abs(x_m) - settings.body_length_m / 2, abs(y_m) - settings.body_width_m / 2
    distance_m = hypot(max(0.0, out_x), max(0.0, out_y))
    if out_y > out_x:
        return ("left" if y_m > 0.0 else "right"), distance_m
    return ("forward" if x_m > 0.0 else "back"), distance_m
