"""Rotations, quaternions and angles, for all of them there are."""

from itertools import permutations, product
from math import degrees, isclose, pi, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.operations.attitude.geometry import (
    axis_map,
    compass_yaw_deg,
    cross,
    dot,
    from_euler,
    heading_deg,
    level,
    minus,
    norm,
    rotation,
    scaled,
    times,
    to_euler,
    turned_about_up,
    wrapped_deg,
)
from lbr.operations.attitude.settings import Mounting
from tests.operations.attitude.imu_bench import apart_deg

angle = st.floats(-720.0, 720.0)
yaws = st.floats(-pi, pi)
vectors = st.tuples(*[st.floats(-100.0, 100.0)] * 3)
ALL_AXES = [
    "".join(sign + axis for sign, axis in zip(signs, axes, strict=True))
    for axes in permutations("xyz")
    for signs in product("+-", repeat=3)
]


def way_back(matrix):
    """The way back of a rotation."""
    return tuple(zip(*matrix, strict=True))


def is_rotation(matrix):
    rows = all(isclose(norm(row), 1.0, abs_tol=1e-9) for row in matrix)
    return rows and norm(minus(cross(matrix[0], matrix[1]), matrix[2])) < 1e-9


@given(st.floats(-1e6, 1e6))
def test_a_heading_is_at_least_zero_and_less_than_a_turn(yaw):
    heading = heading_deg(yaw)
    assert 0.0 <= heading < 360.0
    assert apart_deg(heading, 90.0 - yaw) < 1e-6


@pytest.mark.parametrize("yaw", [90.0, 90.0 + 1e-14, 90.0 - 1e-14, 450.0, -270.0])
def test_north_is_zero_or_almost_a_turn_but_never_a_whole_one(yaw):
    assert 0.0 <= heading_deg(yaw) < 360.0
    assert apart_deg(heading_deg(yaw), 0.0) < 1e-9


@given(angle)
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(value):
    assert -180.0 <= wrapped_deg(value) <= 180.0
    assert apart_deg(wrapped_deg(value), value) < 1e-6


@given(angle, angle, angle)
def test_every_mounting_by_angles_is_a_rotation_with_a_way_back(roll, pitch, yaw):
    matrix = rotation(roll, pitch, yaw)
    assert is_rotation(matrix)
    there = times(matrix, (1.0, 2.0, 3.0))
    assert times(way_back(matrix), there) == pytest.approx((1.0, 2.0, 3.0), abs=1e-9)


@pytest.mark.parametrize("axes", ALL_AXES)
def test_half_of_all_axes_are_a_mounting_and_the_mirrored_ones_are_refused(axes):
    try:
        matrix = axis_map(axes)
    except ValueError as err:
        assert "right-handed" in str(err)  # noqa: PT017 - half of them are good
        return
    assert is_rotation(matrix)


def test_twenty_four_axes_are_good():
    good = 0
    for axes in ALL_AXES:
        try:
            good += is_rotation(Mounting(axes=axes).matrix())
        except ValueError:
            continue
    assert good == 24


def test_axes_and_angles_together_are_refused():
    with pytest.raises(ValueError, match="not both"):
        Mounting(axes="+x+y+z", yaw_deg=90.0)


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_euler_angles_come_back_out_of_a_quaternion(roll, pitch, yaw):
    q = from_euler(roll, pitch, yaw)
    assert isclose(sum(part * part for part in q), 1.0, abs_tol=1e-12)
    assert to_euler(q) == pytest.approx((roll, pitch, yaw), abs=1e-6)


@given(st.floats(-3.0, 3.0), st.floats(-1.4, 1.4), yaws, yaws)
def test_turning_about_the_vertical_changes_the_yaw_alone(roll, pitch, yaw, more):
    turned = to_euler(turned_about_up(from_euler(roll, pitch, yaw), more))
    assert turned[:2] == pytest.approx((roll, pitch), abs=1e-6)
    assert apart_deg(degrees(turned[2]), degrees(yaw + more)) < 1e-4


@given(vectors.filter(lambda v: norm(v) > 1e-3))
def test_a_body_that_sees_up_there_is_level_in_the_world(up):
    unit = scaled(up, 1.0 / norm(up))
    roll, pitch, yaw = to_euler(level(unit))
    assert yaw == pytest.approx(0.0, abs=1e-9) or abs(unit[0]) > 0.999
    seen = times(way_back(rotation(degrees(roll), degrees(pitch), degrees(yaw))), (0.0, 0.0, 1.0))
    assert norm(minus(seen, unit)) < 1e-4


@given(st.floats(-40.0, 40.0), st.floats(-40.0, 40.0), st.floats(-180.0, 180.0), st.floats(-60.0, 60.0))
def test_a_compass_knows_its_yaw_however_it_is_tilted(roll, pitch, yaw, down_ut):
    back = way_back(rotation(roll, pitch, yaw))
    field, up = times(back, (0.0, 20.0, down_ut)), times(back, (0.0, 0.0, 1.0))
    assert apart_deg(compass_yaw_deg(field, up), yaw) < 1e-6


@given(vectors)
def test_a_vertical_field_shows_no_direction(up):
    length = norm(up)
    if length > 1.0:
        assert compass_yaw_deg(scaled(up, 3.0), scaled(up, 1.0 / length)) is None


def test_products_are_right_handed():
    assert cross((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) == (0.0, 0.0, 1.0)
    assert dot((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)) == 32.0
    assert norm((1.0, 1.0, 1.0)) == pytest.approx(sqrt(3.0))
