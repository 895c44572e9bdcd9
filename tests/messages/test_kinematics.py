"""The wheels of a base: from a twist to the speed of each motor, and back."""

from math import hypot, inf, isclose, nan, pi, tau

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.messages.kinematics import Kinematics, Twist, Wheel, base_of, differential, trouble_of

LONG, WIDE = 0.2, 0.15


def four(motor=lambda place, side: f"{place}_{side}", roller=0.0):
    return [
        Wheel(
            name=f"{place}_{side}",
            motor=motor(place, side),
            x_m=x,
            y_m=y,
            roller_rad=-roller if x * y > 0 else roller,
            diameter_m=0.1,
        )
        for place, x in (("front", LONG), ("rear", -LONG))
        for side, y in (("left", WIDE), ("right", -WIDE))
    ]


def star(count):
    """Return omni wheels around the middle, each rolling along the circle."""
    from math import cos, sin

    at = [tau * number / count for number in range(count)]
    return [
        Wheel(
            name=f"w{n}", motor=f"w{n}", x_m=LONG * cos(a), y_m=LONG * sin(a), yaw_rad=a + pi / 2 - pi, diameter_m=0.1
        )
        for n, a in enumerate(at)
    ]


def made(kind, wheels, track_factor=1.0):
    return base_of([Kinematics(name="base", kind=kind, track_factor=track_factor)], wheels, 0.27)


BASES = {
    "without rows": base_of([], [], 0.27),
    "skid in sides": made("skid", four(lambda place, side: side), 1.4),
    "skid of four": made("skid", four(), 1.4),
    "mecanum": made("mecanum", four(roller=pi / 4)),
    "three omni": made("omni", star(3)),
    "four omni": made("omni", star(4)),
    "five omni": made("omni", star(5)),
}
speed = st.floats(-3.0, 3.0)
power = st.floats(-1.0, 1.0)
any_base = st.sampled_from(list(BASES.values()))


def close(one, two):
    return all(isclose(a, b, abs_tol=1e-9) for a, b in zip(one, two, strict=True))


def axes(twist):
    return twist.vx_mps, twist.vy_mps, twist.wz_rps


@given(any_base, speed, speed, speed)
def test_forward_kinematics_are_the_inverse_of_inverse_kinematics(base, vx, vy, wz):
    twist = Twist(vx_mps=vx, vy_mps=vy if base.holonomic else 0.0, wz_rps=wz)
    assert close(axes(base.twist(base.speeds(twist))), axes(twist))


@given(any_base, power, power, power)
def test_sides_of_powers_are_the_sides(base, left, right, aside):
    aside = aside if base.holonomic else 0.0
    assert close(base.sides(base.powers(left, right, aside)), (left, right, aside))


@given(any_base, power, power, power, st.floats(0.05, 1.0))
def test_what_is_fitted_keeps_its_form_and_no_motor_gets_more(base, left, right, aside, most):
    aside = aside if base.holonomic else 0.0
    share = base.fitting(left, right, aside, most)
    assert 0.0 <= share <= 1.0
    before, after = base.powers(left, right, aside), base.powers(left * share, right * share, aside * share)
    assert max(map(abs, after)) <= most + 1e-9
    assert close(after, [share * one for one in before])
    assert share == 1.0 or isclose(max(map(abs, after)), most, abs_tol=1e-9)


@pytest.mark.parametrize("bad", [nan, inf, -inf])
@pytest.mark.parametrize("base", BASES.values(), ids=BASES)
def test_what_is_no_number_moves_nothing(base, bad):
    for at in range(3):
        sides = [0.5, 0.5, 0.0]
        sides[at] = bad
        assert base.fitting(*sides, 1.0) == 0.0


@given(st.floats(0.05, 2.0), speed, speed)
def test_two_wheels_are_as_the_textbook_has_them(track_m, left, right):
    base = differential(track_m)
    assert base.two
    vx, vy, wz = axes(base.twist((left, right)))
    assert vy == 0.0
    assert isclose(vx, (left + right) / 2, abs_tol=1e-12)
    assert isclose(wz, (right - left) / track_m, abs_tol=1e-9)


@given(speed, speed, speed)
def test_mecanum_wheels_are_as_the_textbook_has_them(vx, vy, wz):
    base = BASES["mecanum"]
    speeds = dict(zip(base.motors, base.speeds(Twist(vx_mps=vx, vy_mps=vy, wz_rps=wz)), strict=True))
    arm = LONG + WIDE
    expected = {
        "front_left": vx - vy - arm * wz,
        "front_right": vx + vy + arm * wz,
        "rear_left": vx + vy - arm * wz,
        "rear_right": vx - vy + arm * wz,
    }
    assert close([speeds[name] for name in expected], expected.values())


@given(speed)
def test_omni_wheels_around_the_middle_turn_alike_in_a_spin(wz):
    speeds = BASES["three omni"].speeds(Twist(wz_rps=wz))
    assert close(map(abs, speeds), [abs(wz) * LONG] * 3)


def test_a_factor_makes_slipping_wheels_turn_farther():
    assert isclose(BASES["skid of four"].track_m, 2 * WIDE * 1.4)
    assert isclose(BASES["mecanum"].track_m, 2 * (LONG + WIDE))


def test_several_wheels_may_be_on_one_motor():
    assert BASES["skid in sides"].two
    assert BASES["skid of four"].motors == ("front_left", "front_right", "rear_left", "rear_right")


@pytest.mark.parametrize(
    ("kind", "wheels"),
    [
        ("skid", []),
        ("differential", four()),
        ("skid", four()[::2]),
        ("skid", star(3)),
        ("mecanum", four()),
        ("omni", four(roller=pi / 4)),
        ("omni", star(2)),
        ("omni", four()),
        (
            "skid",
            four(lambda place, side: "left" if (place, side) != ("rear", "right") else "right"),
        ),
    ],
)
def test_wheels_that_make_no_such_base_are_refused(kind, wheels, wording):
    wording(trouble_of(kind, wheels, 1.0))
    with pytest.raises(ValueError, match="kinematics 'base'"):
        made(kind, wheels)


@given(any_base, power, power, power)
def test_a_base_pushed_by_its_motors_goes_no_faster_than_they_do(base, left, right, aside):
    twist = base.twist(base.powers(left, right, aside if base.holonomic else 0.0))
    assert hypot(*axes(twist)[:2]) <= 2.0 + 1e-9
