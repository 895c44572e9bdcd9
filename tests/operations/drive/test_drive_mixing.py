"""Power and angle to wheels: the published vectors, and what holds for every angle."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.operations.drive.mixing import mix
from lbr.operations.drive.settings import DriveSettings

CLAMPED = DriveSettings(mixing="clamped")
NORMALISED = DriveSettings()
ANGLES = (0, 30, 45, 60, 90, 135, 180, 225, 270, 315)
VECTORS = {
    1.0: "1000,1000 1000,366 1000,0 1000,-367 1000,-1000 0,-1000 -1000,-1000 -1000,0 -1000,1000 0,1000",
    0.5: "500,500 683,183 706,0 682,-184 500,-500 0,-706 -500,-500 -706,0 -500,500 0,706",
    0.25: "250,250 341,91 352,0 340,-92 250,-250 0,-352 -250,-250 -352,0 -250,250 0,352",
    0.2: "200,200 273,73 282,0 272,-74 200,-200 0,-282 -200,-200 -282,0 -200,200 0,282",
}
ROWS = [
    (power, angle, tuple(int(n) for n in pair.split(",")))
    for power, line in VECTORS.items()
    for angle, pair in zip(ANGLES, line.split(), strict=True)
]
powers = st.floats(0.0, 1.0)
angles = st.floats(-360.0, 360.0)
any_settings = st.builds(
    DriveSettings,
    mixing=st.sampled_from(["normalised", "clamped"]),
    reverse_steering=st.sampled_from(["rotation", "travel"]),
    heading_offset_deg=st.floats(-8.0, 8.0),
)


@pytest.mark.parametrize(("power", "angle", "expected"), ROWS)
def test_clamped_mixing_gives_the_known_vectors(power, angle, expected):
    got = [1000 * wheel for wheel in mix(power, angle, CLAMPED)]
    assert got == pytest.approx(expected, abs=1.0001)


@pytest.mark.parametrize(
    ("angle", "expected"),
    [(0, (0.5, 0.5)), (45, (0.5, 0.0)), (90, (0.5, -0.5)), (135, (0.0, -0.5)), (180, (-0.5, -0.5)), (-90, (-0.5, 0.5))],
)
def test_normalised_mixing_never_drives_a_wheel_faster_than_asked(angle, expected):
    assert mix(0.5, angle, NORMALISED) == pytest.approx(expected)


def test_rotation_steering_turns_clockwise_in_reverse_too():
    left, right = mix(0.5, 150, NORMALISED)
    assert left + right < 0
    assert left > right


def test_travel_steering_curves_the_reversing_path_to_the_side_asked_for():
    left, right = mix(0.5, 150, DriveSettings(reverse_steering="travel"))
    assert left + right < 0
    assert left < right, "the tail goes right when the nose turns left"


def test_travel_steering_leaves_spins_and_forward_arcs_alone():
    travel = DriveSettings(reverse_steering="travel")
    for angle in (0, 30, 90, 270, 330, 360, -90):
        assert mix(0.5, angle, travel) == mix(0.5, angle, NORMALISED)


@pytest.mark.parametrize(("angle", "same_as"), [(0, 4), (180, 184), (360, 4), (-180, -176), (1, 1), (90, 90)])
def test_heading_offset_is_added_straight_ahead_and_back_only(angle, same_as):
    assert mix(0.5, angle, DriveSettings(heading_offset_deg=4.0)) == pytest.approx(mix(0.5, same_as, NORMALISED))


@given(powers, angles)
def test_angles_are_periodic(power, angle):
    other = angle - 360.0 if angle > 0 else angle + 360.0
    assert mix(power, angle, NORMALISED) == pytest.approx(mix(power, other, NORMALISED), abs=1e-5)


@given(powers, angles, any_settings)
def test_wheels_are_always_finite_and_within_full_power(power, angle, settings):
    assert all(math.isfinite(wheel) and abs(wheel) <= 1.0 for wheel in mix(power, angle, settings))


@given(powers, angles)
def test_the_faster_wheel_has_the_power_asked_for(power, angle):
    left, right = mix(power, angle, NORMALISED)
    assert max(abs(left), abs(right)) == pytest.approx(power, abs=1e-5)
