"""The body of a wheeled base, from its rows: wheels, sensors, and a deck as large as their outline.

It is the body of the simulated world, as far as rows describe it.
"""

from collections.abc import Sequence
from math import cos, pi, sin

from lbr.apps.bodies.parts import Body, Link, Rgba, Sensor, Shape
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor

CLEARANCE_M = 0.04
DECK_M = 0.20
WHEEL_WIDTH_M = 0.04
CASTER_M = 0.03
WHEEL_DIAMETER_M = 0.1778
LENGTH_M, WIDTH_M = 0.43, 0.30
"""The measures of the robot lbr, for values that no row has."""
LEVEL_M = 0.6
"""A sensor higher than this is on a mast, and outside the deck's outline."""
_SHELL: Rgba = (0.86, 0.87, 0.89, 1.0)
_DARK: Rgba = (0.16, 0.17, 0.20, 1.0)
_EYE: Rgba = (0.10, 0.45, 0.80, 1.0)


def body(wheels: Sequence[Wheel], sensors: Sequence[RangeSensor]) -> Body:
    """Return the body of a base with these rows; without rows of wheels it has two, as the robot lbr has."""
    length, width = outline_m(wheels, sensors)
    driven = tuple(wheels) or two_wheels(width)
    axle = max(wheel.diameter_m for wheel in driven) / 2
    half_deck = width / 2 if min(abs(wheel.y_m) for wheel in driven) > width / 2 else width / 2 - WHEEL_WIDTH_M
    deck = Shape(
        kind="box",
        size=(length, max(2 * half_deck, WHEEL_WIDTH_M), DECK_M),
        xyz=(0.0, 0.0, CLEARANCE_M + DECK_M / 2 - axle),
        rgba=_SHELL,
    )
    nose = Shape(
        kind="box",
        size=(0.004, 0.5 * width, 0.03),
        xyz=(length / 2, 0.0, CLEARANCE_M + 0.75 * DECK_M - axle),
        rgba=_EYE,
    )
    base = Link(
        name="base",
        origin_xyz=(0.0, 0.0, axle),
        shapes=(deck, nose, *_casters(driven, length, axle), *(_eye(sensor, axle) for sensor in sensors)),
    )
    return Body(
        links=(base, *(_wheel(wheel, axle) for wheel in driven)),
        joints={wheel.name: "wheel" for wheel in driven},
        sensors=tuple(_sensor(sensor, axle) for sensor in sensors),
    )


def outline_m(wheels: Sequence[Wheel], sensors: Sequence[RangeSensor]) -> tuple[float, float]:
    """Return length and width of the outline of wheels and low sensors, centred."""
    ahead, aside = [0.0], [0.0]
    for wheel in wheels:
        along, across, half = abs(cos(wheel.yaw_rad)), abs(sin(wheel.yaw_rad)), WHEEL_WIDTH_M / 2
        ahead.append(abs(wheel.x_m) + along * wheel.diameter_m / 2 + across * half)
        aside.append(abs(wheel.y_m) + across * wheel.diameter_m / 2 + along * half)
    for one in sensors:
        if one.z_m <= LEVEL_M:
            ahead.append(abs(one.x_m))
            aside.append(abs(one.y_m))
    least = 0.0 if wheels else 0.1
    return (
        2 * max(ahead) if max(ahead) > least else LENGTH_M,
        2 * max(aside) if max(aside) > least else WIDTH_M,
    )


def two_wheels(width_m: float) -> tuple[Wheel, ...]:
    """Return the default wheels of a robot without rows for them."""
    half = (width_m - WHEEL_WIDTH_M) / 2
    return tuple(
        Wheel(name=name, motor=name, y_m=side * half, diameter_m=WHEEL_DIAMETER_M)
        for name, side in (("left", 1), ("right", -1))
    )


def _wheel(wheel: Wheel, axle_m: float) -> Link:
    radius = wheel.diameter_m / 2
    tyre = Shape(kind="cylinder", size=(radius, WHEEL_WIDTH_M), rpy=(pi / 2, 0.0, 0.0), rgba=_DARK)
    spoke = Shape(kind="box", size=(1.4 * radius, WHEEL_WIDTH_M + 0.002, 0.016), rgba=_SHELL)
    return Link(
        name=f"{wheel.name}_wheel",
        parent="base",
        joint=wheel.name,
        axis=(0.0, 1.0, 0.0),
        origin_xyz=(wheel.x_m, wheel.y_m, radius - axle_m),
        origin_rpy=(0.0, 0.0, wheel.yaw_rad),
        shapes=(tyre, spoke),
    )


def _casters(wheels: Sequence[Wheel], length_m: float, axle_m: float) -> tuple[Shape, ...]:
    """Return the casters of a base whose wheels alone do not keep it from tipping over."""
    if min(wheel.x_m for wheel in wheels) < 0.0 < max(wheel.x_m for wheel in wheels):
        return ()
    x = length_m / 2 - CASTER_M
    return tuple(Shape(kind="sphere", size=(CASTER_M,), xyz=(at, 0.0, CASTER_M - axle_m), rgba=_DARK) for at in (x, -x))


def _eye(sensor: RangeSensor, axle_m: float) -> Shape:
    if sensor.rays > 1:
        size = 0.035, 0.04
        return Shape(kind="cylinder", size=size, xyz=(sensor.x_m, sensor.y_m, sensor.z_m - axle_m), rgba=_DARK)
    one = _sensor(sensor, axle_m)
    return Shape(kind="box", size=(0.012, 0.03, 0.02), xyz=one.xyz, rpy=one.rpy, rgba=_EYE)


def _sensor(sensor: RangeSensor, axle_m: float) -> Sensor:
    return Sensor(
        name=sensor.name,
        kind=sensor.kind,
        link="base",
        xyz=(sensor.x_m, sensor.y_m, sensor.z_m - axle_m),
        rpy=(0.0, sensor.pitch_rad, sensor.yaw_rad),
        fov_rad=sensor.fov_rad,
        max_m=sensor.max_m,
    )
