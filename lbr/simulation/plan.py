"""Plan geometry: positions seen from above, and the conversion of metres to dots."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import cos, sin, tau

from lbr.messages.sensing import Ranges, RangeSensor, ring
from lbr.simulation.messages import WorldBox, WorldDock, WorldPose, WorldScene

Point = tuple[float, float]

_MARGIN_M = 0.15
_OVERHEAD_M = 1.9
_ROUND = 12


@dataclass(frozen=True, slots=True)
class Scale:
    """Metres to dots: x to the right, y up, the same scale both ways, centred."""

    centre: Point
    dots_per_m: float
    width: int
    height: int

    def dot(self, point: Point) -> Point:
        """Return the dot of a point."""
        x = self.width / 2 + (point[0] - self.centre[0]) * self.dots_per_m
        return x, self.height / 2 - (point[1] - self.centre[1]) * self.dots_per_m


def fit(scene: WorldScene, pose: WorldPose, width: int, height: int) -> Scale:
    """Return the scale at which everything fits into `width` by `height` dots."""
    points = [point for box in scene.walls for point in box_corners(box)]
    points += robot_corners(scene, pose)
    west, east = min(x for x, _ in points) - _MARGIN_M, max(x for x, _ in points) + _MARGIN_M
    south, north = min(y for _, y in points) - _MARGIN_M, max(y for _, y in points) + _MARGIN_M
    dots_per_m = min(width / (east - west), height / (north - south))
    return Scale(((west + east) / 2, (south + north) / 2), dots_per_m, width, height)


def below(scene: WorldScene) -> list[WorldBox]:
    """Return the things below head height, the lowest first, so that upper ones cover lower ones."""
    return sorted(
        (box for box in scene.walls if box.bottom_m < _OVERHEAD_M), key=lambda box: box.bottom_m + box.height_m
    )


def box_corners(box: WorldBox) -> list[Point]:
    """Return a box's corners, anticlockwise; a cylinder has twelve."""
    if box.kind == "box":
        return _placed(box, _rectangle(box.length_m, box.width_m))
    radius, angles = box.length_m / 2, (tau * step / _ROUND for step in range(_ROUND))
    return [(box.x_m + radius * cos(angle), box.y_m + radius * sin(angle)) for angle in angles]


def dock_corners(dock: WorldDock) -> list[Point]:
    """Return the corners of the dock, anticlockwise."""
    half, depth = dock.width_m / 2, dock.depth_m
    return _placed(dock, ((0.0, half), (-depth, half), (-depth, -half), (0.0, -half)))


def dock_beams(dock: WorldDock) -> Iterator[list[Point]]:
    """Yield the area of the left beam and that of the right one: the dock's face, then the arc that they reach."""
    near, far = -dock.overlap_rad / 2, dock.spread_rad
    for side in (1, -1):
        ways = [side * (near + (far - near) * step / 8) for step in range(9)]
        yield _placed(dock, ((0.0, 0.0), *((dock.reach_m * cos(way), dock.reach_m * sin(way)) for way in ways)))


def robot_corners(scene: WorldScene, pose: WorldPose) -> list[Point]:
    """Return the corners of the robot's outline, anticlockwise from ahead on the left."""
    return _placed(pose, _rectangle(scene.robot_length_m, scene.robot_width_m))


def robot_arrow(scene: WorldScene, pose: WorldPose) -> list[Point]:
    """Return a triangle within the outline that points ahead."""
    length, width = scene.robot_length_m / 2, scene.robot_width_m / 2
    return _placed(pose, ((length, 0.0), (-length * 0.6, width * 0.8), (-length * 0.6, -width * 0.8)))


def cones(scene: WorldScene, pose: WorldPose, ranges: Ranges) -> Iterator[tuple[str, list[Point]]]:
    """Yield each measured range as a cone: the sensor's place, then the arc of the echo."""
    for sensor in scene.sensors or _ring(scene):
        range_m = ranges.metres(sensor.name)
        if range_m is None:
            continue
        origin = (sensor.x_m, sensor.y_m)
        arc = [sensor.yaw_rad + sensor.fov_rad / 2 * step / 4 for step in range(-4, 5)]
        rim = ((origin[0] + range_m * cos(way), origin[1] + range_m * sin(way)) for way in arc)
        yield sensor.name, _placed(pose, (origin, *rim))


def _ring(scene: WorldScene) -> Iterator[RangeSensor]:
    """Yield the ring of a world that does not list its sensors."""
    return (sensor for sensor in ring(scene.robot_length_m, scene.robot_width_m) if sensor.level)


def _rectangle(length: float, width: float) -> tuple[Point, ...]:
    ahead, side = length / 2, width / 2
    return ((ahead, side), (-ahead, side), (-ahead, -side), (ahead, -side))


def _placed(place: WorldBox | WorldPose | WorldDock, points: Iterable[Point]) -> list[Point]:
    c, s = cos(place.yaw_rad), sin(place.yaw_rad)
    return [(place.x_m + c * x - s * y, place.y_m + s * x + c * y) for x, y in points]
