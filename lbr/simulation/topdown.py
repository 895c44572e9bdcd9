"""The world from above, from its messages alone: as text for a terminal, or as a picture."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import degrees, pi
from typing import TYPE_CHECKING

from lbr.messages.sensing import Ranges
from lbr.simulation.braille import Canvas
from lbr.simulation.messages import WorldBox, WorldPose, WorldScene
from lbr.simulation.plan import (
    Point,
    below,
    box_corners,
    cones,
    dock_beams,
    dock_corners,
    fit,
    robot_arrow,
    robot_corners,
)

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

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
