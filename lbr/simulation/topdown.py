"""The world from above, from its messages alone: as text for a terminal, or as a picture."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, degrees, pi, sin, tau
from typing import TYPE_CHECKING

from lbr.messages.sensing import Ranges, RangeSensor, ring
from lbr.simulation.braille import Canvas
from lbr.simulation.messages import WorldBox, WorldDock, WorldPose, WorldScene

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw


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


ARROWS = "→↗↑↖←↙↓↘"
"""The robot's heading in eighths, anticlockwise from x."""

_SIDES = ("forward", "left", "right", "back")
_LEGEND_PX = 48
_BAR = 5
_PAPER, _WALL, _INK = (250, 250, 247), (96, 104, 112), (30, 34, 40)
_TRAIL, _BODY, _BUMPED, _CONE = (86, 156, 214), (46, 160, 67), (207, 34, 46), (255, 170, 0, 60)
_BEAMS, _RUG_ALPHA = ((207, 34, 46, 26), (46, 120, 200, 26)), 90


def text(
    scene: WorldScene, pose: WorldPose, ranges: Ranges | None = None, width: int = 80, height: int = 24
) -> list[str]:
    """Return the view as at most `height` lines of `width` characters, the legend last."""
    legend = legend_lines(pose, ranges)
    canvas = Canvas(max(1, width), max(1, height - len(legend)))
    scale = fit(scene, pose, canvas.width, canvas.height)
    for box in below(scene):
        canvas.outline([scale.dot(corner) for corner in box_corners(box)], every=1 if box.solid else 4)
    if scene.dock:
        canvas.outline([scale.dot(corner) for corner in dock_corners(scene.dock)])
        for face, *arc in dock_beams(scene.dock):
            canvas.line(scale.dot(face), scale.dot(arc[-1]), every=5)
    for _, (origin, *rim) in cones(scene, pose, ranges) if ranges else ():
        canvas.line(scale.dot(origin), scale.dot(rim[len(rim) // 2]), every=4)
        for start, end in pairwise(rim):
            canvas.line(scale.dot(start), scale.dot(end), every=2)
    canvas.outline([scale.dot(corner) for corner in robot_corners(scene, pose)])
    canvas.letter(*scale.dot((pose.x_m, pose.y_m)), arrow(pose))
    return [line[:width] for line in (*canvas.lines(), *legend)][-max(1, height) :]


def arrow(pose: WorldPose) -> str:
    """Return the arrow nearest to the robot's heading."""
    return ARROWS[round(pose.yaw_rad / (pi / 4)) % 8]


def legend_lines(pose: WorldPose, ranges: Ranges | None = None) -> list[str]:
    """Return pose, wheel power and ranges in words; degrees clockwise, as at the console."""
    heading = round(-degrees(pose.yaw_rad)) % 360
    place = f"x {pose.x_m:+.2f} m  y {pose.y_m:+.2f} m  heading {heading}°  {pose.speed_mps:+.2f} m/s"
    state = _state_words(pose, "  ")
    wheels = f"left {power_bar(pose.left)} {pose.left:+.2f}  right {power_bar(pose.right)} {pose.right:+.2f}"
    lines = [f"{place}  {pose.battery_v:.1f} V{state}", wheels]
    if ranges:
        lines.append("ranges  " + "  ".join(_range_words(side, ranges) for side in (*_SIDES, *ranges.others_m)))
    return lines


def power_bar(power: float) -> str:
    """Return a bar from the middle: to the right ahead, to the left back."""
    filled = round(min(1.0, abs(power)) * _BAR)
    back, ahead = (0, filled) if power > 0 else (filled, 0)
    return f"{'█' * back:>{_BAR}}│{'█' * ahead:<{_BAR}}"


def image(
    scene: WorldScene,
    pose: WorldPose,
    ranges: Ranges | None = None,
    *,
    trail: Sequence[Point] = (),
    width: int = 900,
    height: int = 750,
) -> "Image":
    """Return the view as a picture, with the robot's trail and a scale; needs Pillow."""
    from PIL import Image, ImageDraw

    picture = Image.new("RGB", (width, height), _PAPER)
    draw = ImageDraw.Draw(picture, "RGBA")
    scale = fit(scene, pose, width, max(1, height - _LEGEND_PX))

    def dots(points: Iterable[Point]) -> list[Point]:
        return [scale.dot(point) for point in points]

    for box in (box for box in below(scene) if not box.solid):
        draw.polygon(dots(box_corners(box)), fill=(*_colour(box), _RUG_ALPHA))
    if scene.dock:
        for colour, beam in zip(_BEAMS, dock_beams(scene.dock), strict=True):
            draw.polygon(dots(beam), fill=colour)
        draw.polygon(dots(dock_corners(scene.dock)), fill=_INK)
    for _, cone in cones(scene, pose, ranges) if ranges else ():
        draw.polygon(dots(cone), fill=_CONE)
    for box in (box for box in below(scene) if box.solid):
        draw.polygon(dots(box_corners(box)), fill=_colour(box))
    if len(trail) > 1:
        draw.line(dots(trail), fill=_TRAIL, width=3, joint="curve")
    draw.polygon(dots(robot_corners(scene, pose)), fill=_BUMPED if pose.touching else _BODY, outline=_INK)
    draw.polygon(dots(robot_arrow(scene, pose)), fill=_PAPER)
    _write_legend(draw, pose, ranges, (width, height), scale.dots_per_m)
    return picture


def _colour(box: WorldBox) -> tuple[int, int, int]:
    red, green, blue = (int(box.colour[at : at + 2], 16) for at in (1, 3, 5)) if box.colour else _WALL
    return red, green, blue


def _write_legend(
    draw: "ImageDraw", pose: WorldPose, ranges: Ranges | None, size: tuple[int, int], dots_per_m: float
) -> None:
    from PIL import ImageFont

    font = ImageFont.load_default(size=13)
    width, height = size
    heading = round(-degrees(pose.yaw_rad)) % 360
    place = f"x {pose.x_m:+.2f} m   y {pose.y_m:+.2f} m   heading {heading} deg   {pose.speed_mps:+.2f} m/s"
    wheels = f"wheels {pose.left:+.2f} {pose.right:+.2f}   {pose.battery_v:.1f} V{_state_words(pose, '   ')}"
    rows = [f"{place}   {wheels}"]
    if ranges:
        rows.append("ranges   " + "   ".join(_range_words(side, ranges) for side in (*_SIDES, *ranges.others_m)))
    for index, row in enumerate(rows):
        draw.text((10, height - _LEGEND_PX + 6 + 18 * index), row, fill=_INK, font=font)
    east = width - 12
    draw.line([(east - dots_per_m, height - 10), (east, height - 10)], fill=_INK, width=3)
    draw.text((east - dots_per_m, height - 28), "1 m", fill=_INK, font=font)


def _state_words(pose: WorldPose, gap: str) -> str:
    words = [word for word, so in (("TOUCHING", pose.touching), ("CHARGING", pose.charging)) if so]
    return "".join(gap + word for word in words)


def _range_words(side: str, ranges: Ranges) -> str:
    range_m = ranges.metres(side)
    return f"{side} {ranges.status.get(side, '-')}" if range_m is None else f"{side} {range_m:.2f} m"
