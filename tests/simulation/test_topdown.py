"""The view from above, drawn from messages alone."""

from dataclasses import replace
from math import cos, hypot, pi, sin

import msgspec
import pytest

from lbr.messages.sensing import Ranges
from lbr.simulation.messages import WorldBox, WorldDock, WorldPose, WorldScene, WorldSensor
from lbr.simulation.topdown import (
    arrow,
    below,
    box_corners,
    cones,
    dock_beams,
    dock_corners,
    fit,
    image,
    legend_lines,
    power_bar,
    text,
)

SCENE = WorldScene(
    walls=(WorldBox(name="north", x_m=2.0, y_m=0.0, length_m=0.1, width_m=4.0),),
    robot_length_m=0.43,
    robot_width_m=0.3,
)
POSE = WorldPose(
    x_m=0.0,
    y_m=0.0,
    yaw_rad=0.0,
    speed_mps=0.4,
    turn_rps=0.0,
    left=0.5,
    right=-0.25,
    touching=False,
    battery_v=12.4,
    time_s=1.0,
)
RANGES = Ranges(
    forward_m=1.73,
    back_m=None,
    left_m=0.6,
    right_m=3.1,
    bottom_m=None,
    status={"back": "over_range", "bottom": "missing"},
)


@pytest.mark.parametrize(
    ("yaw", "expected"),
    [(0, "→"), (pi / 2, "↑"), (-pi / 2, "↓"), (pi, "←"), (-pi, "←"), (pi / 4, "↗"), (-3 * pi / 4, "↙"), (7, "↗")],
)
def test_the_arrow_shows_the_heading(yaw, expected):
    pose = msgspec.structs.replace(POSE, yaw_rad=yaw)
    assert arrow(pose) == expected
    assert sum(line.count(expected) for line in text(SCENE, pose)) == 1


@pytest.mark.parametrize(("width", "height"), [(80, 24), (120, 40), (20, 8), (1, 1), (5, 2)])
def test_text_keeps_to_its_space(width, height):
    lines = text(SCENE, POSE, RANGES, width, height)
    assert len(lines) <= height
    assert all(len(line) <= width for line in lines)


def test_the_legend_tells_pose_power_and_ranges():
    place, wheels, ranges = text(SCENE, msgspec.structs.replace(POSE, yaw_rad=-pi / 2, touching=True), RANGES)[-3:]
    assert "heading 90°" in place
    assert "12.4 V" in place
    assert "TOUCHING" in place
    assert "left      │██    +0.50  right     █│      -0.25" in wheels
    assert "forward 1.73 m" in ranges
    assert "back over_range" in ranges


def test_a_sensor_of_any_name_is_seen_where_it_sits():
    bow = WorldSensor(name="bow", x_m=0.2, y_m=0.1, yaw_rad=pi / 2, fov_rad=0.2)
    scene = msgspec.structs.replace(SCENE, sensors=(bow,))
    seen = msgspec.structs.replace(RANGES, others_m={"bow": 1.0})
    ((name, cone),) = cones(scene, msgspec.structs.replace(POSE, x_m=1.0, y_m=0.0, yaw_rad=0.0), seen)
    assert name == "bow"
    assert cone[0] == pytest.approx((1.2, 0.1))
    assert cone[5] == pytest.approx((1.2, 1.1))
    assert "bow 1.00 m" in legend_lines(POSE, seen)[-1]
    assert [name for name, _ in cones(SCENE, POSE, RANGES)] == ["forward", "left", "right"]


def test_power_bars_go_both_ways():
    assert power_bar(1.0) == "     │█████"
    assert power_bar(-0.4) == "   ██│     "
    assert power_bar(0.0) == "     │     "


def test_the_robot_moves_across_the_text():
    def column(x_m):
        lines = text(SCENE, msgspec.structs.replace(POSE, x_m=x_m))
        return next(line.index("→") for line in lines if "→" in line)

    assert column(-0.5) < column(0.0) < column(1.0)


def test_north_of_the_robot_is_up():
    scale = fit(SCENE, POSE, 100, 100)
    assert scale.dot((0, 1))[1] < scale.dot((0, 0))[1]
    assert scale.dot((1, 0))[0] > scale.dot((0, 0))[0]
    assert replace(scale, dots_per_m=1.0).dot(scale.centre) == (50, 50)


def test_the_picture_has_wall_robot_trail_and_cones():
    picture = image(SCENE, POSE, RANGES, trail=((-1.0, 0.0), (0.0, 0.0)), width=500, height=400)
    scale = fit(SCENE, POSE, 500, 352)

    def colour(x, y):
        return picture.getpixel(tuple(round(value) for value in scale.dot((x, y))))

    paper = colour(-1.5 + 1.6, 1.5)
    assert picture.size == (500, 400)
    assert colour(2.0, 0.5) == (96, 104, 112)
    assert colour(-0.19, 0.1) == (46, 160, 67)
    assert colour(1.0, 0.0) not in {paper, (96, 104, 112)}
    bumped = image(SCENE, msgspec.structs.replace(POSE, touching=True), width=500, height=400)
    assert bumped.getpixel(tuple(round(value) for value in scale.dot((-0.19, 0.1)))) == (207, 34, 46)


DOCK = WorldDock(x_m=-1.0, y_m=0.0, yaw_rad=0.0, depth_m=0.3, width_m=0.4, reach_m=2.0, spread_rad=0.4, overlap_rad=0.1)


def test_a_dock_is_drawn_with_what_its_beams_cover():
    left, right = dock_beams(DOCK)
    assert left[0] == right[0] == pytest.approx((-1.0, 0.0))
    assert left[-1] == pytest.approx((-1.0 + 2.0 * cos(0.4), 2.0 * sin(0.4)))
    assert left[1][1] < 0 < right[1][1]
    assert [x for x, _ in dock_corners(DOCK)] == pytest.approx([-1.0, -1.3, -1.3, -1.0])
    scene = msgspec.structs.replace(SCENE, dock=DOCK)
    with_dock, without = (image(each, POSE, width=500, height=400) for each in (scene, SCENE))
    scale = fit(SCENE, POSE, 500, 352)
    assert with_dock.getpixel(tuple(round(value) for value in scale.dot((0.3, 0.3)))) != without.getpixel((250, 170))
    assert sum(map(len, text(scene, POSE))) == sum(map(len, text(SCENE, POSE)))
    assert text(scene, POSE)[:-2] != text(SCENE, POSE)[:-2]


def test_furniture_has_its_colour_and_shape_and_what_hangs_overhead_is_left_out():
    pot = WorldBox(name="pot", x_m=1.0, y_m=1.0, length_m=0.4, width_m=0.4, kind="cylinder", colour="#102030")
    lintel = WorldBox(name="lintel", x_m=-0.5, y_m=1.0, length_m=0.4, width_m=0.4, bottom_m=2.0)
    scene = msgspec.structs.replace(SCENE, walls=(*SCENE.walls, pot, lintel))
    assert [box.name for box in below(scene)] == ["north", "pot"]
    assert len(box_corners(pot)) == 12
    assert all(hypot(x - 1.0, y - 1.0) == pytest.approx(0.2) for x, y in box_corners(pot))
    scale = fit(scene, POSE, 500, 352)
    colour = image(scene, POSE, width=500, height=400).getpixel(tuple(round(value) for value in scale.dot((1.0, 1.0))))
    assert colour == (0x10, 0x20, 0x30)


def test_charging_is_told():
    assert "CHARGING" in text(SCENE, msgspec.structs.replace(POSE, charging=True))[-2]
    assert "CHARGING" not in text(SCENE, POSE)[-2]
