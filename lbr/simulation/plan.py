"""Plan geometry: where things are seen from above, and how metres become dots."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import cos, pi, sin

from lbr.messages.sensing import Ranges
from lbr.messages.simulation import WorldBox, WorldPose, WorldScene

Point = tuple[float, float]

CONE_RAD = 0.20
"""Half the angle in which an ultrasonic sensor hears its echo."""

_SIDES = (("forward", 0.0), ("left", pi / 2), ("right", -pi / 2), ("back", pi))
_MARGIN_M = 0.15


@dataclass(frozen=True, slots=True)
class Scale:
    """Metres to dots: x to the right, y up, the same scale both ways, centred."""

    centre: Point
    dots_per_m: float
    width: int
    height: int

    def dot(self, point: Point) -> Point:
        """Return where a point is drawn."""
        x = self.width / 2 + (point[0] - self.centre[0]) * self.dots_per_m
        return x, self.height / 2 - (point[1] - self.centre[1]) * self.dots_per_m


def fit(scene: WorldScene, pose: WorldPose, width: int, height: int) -> Scale:
    """Return the scale at which everything is seen in `width` by `height` dots."""
    points = [point for box in scene.walls for point in box_corners(box)]
    points += robot_corners(scene, pose)
    west, east = min(x for x, _ in points) - _MARGIN_M, max(x for x, _ in points) + _MARGIN_M
    south, north = min(y for _, y in points) - _MARGIN_M, max(y for _, y in points) + _MARGIN_M
    dots_per_m = min(width / (east - west), height / (north - south))
    return Scale(((west + east) / 2, (south + north) / 2), dots_per_m, width, height)


def box_corners(box: WorldBox) -> list[Point]:
    """Return a box's corners, anticlockwise."""
    return _placed(box, _rectangle(box.length_m, box.width_m))


def robot_corners(scene: WorldScene, pose: WorldPose) -> list[Point]:
    """Return the corners of the robot's outline, anticlockwise from ahead on the left."""
    return _placed(pose, _rectangle(scene.robot_length_m, scene.robot_width_m))


def robot_arrow(scene: WorldScene, pose: WorldPose) -> list[Point]:
    """Return a triangle within the outline that points ahead."""
    length, width = scene.robot_length_m / 2, scene.robot_width_m / 2
    return _placed(pose, ((length, 0.0), (-length * 0.6, width * 0.8), (-length * 0.6, -width * 0.8)))


def cones(scene: WorldScene, pose: WorldPose, ranges: Ranges) -> Iterator[tuple[str, list[Point]]]:
    """Yield each measured range as the cone it stands for: the sensor's place, then the arc of the echo."""
    for side, angle in _SIDES:
        range_m: float | None = getattr(ranges, f"{side}_m")
        if range_m is None:
            continue
        offset = (scene.robot_length_m if side in {"forward", "back"} else scene.robot_width_m) / 2
        origin = (offset * cos(angle), offset * sin(angle))
        arc = [angle + CONE_RAD * step / 4 for step in range(-4, 5)]
        rim = ((origin[0] + range_m * cos(way), origin[1] + range_m * sin(way)) for way in arc)
        yield side, _placed(pose, (origin, *rim))


def _rectangle(length: float, width: float) -> tuple[Point, ...]:
    ahead, side = length / 2, width / 2
    return ((ahead, side), (-ahead, side), (-ahead, -side), (ahead, -side))


def _placed(place: WorldBox | WorldPose, points: Iterable[Point]) -> list[Point]:
    c, s = cos(place.yaw_rad), sin(place.yaw_rad)
    return [(place.x_m + c * x - s * y, place.y_m + s * x + c * y) for x, y in points]
