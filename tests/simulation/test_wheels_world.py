"""A world whose robot has the wheels of its rows: skid steering slips, and the odometry knows by how much."""

from math import cos, pi, sin

import pytest
from msgspec.structs import replace

from lbr.messages.kinematics import Kinematics, Twist, Wheel, base_of
from lbr.messages.motors import MotorsState
from lbr.operations.odometry import OdometrySettings
from lbr.operations.odometry.reckoning import Reckoning
from lbr.simulation.engine import Engine
from lbr.simulation.settings import Body, WorldSettings

STEP_S = 0.02
FACTOR = 1.8
BODY = Body(length_m=0.45, width_m=0.42, height_m=0.5, mass_kg=14.0, counts_per_turn=400, max_speed_mps=0.8)
WORLD = WorldSettings(walls=(), dock=None, body=BODY)


def four(motor):
    return [
        Wheel(name=f"{place}_{side}", motor=motor(place, side), x_m=x, y_m=y, diameter_m=0.15)
        for place, x in (("front", 0.13), ("rear", -0.13))
        for side, y in (("left", 0.18), ("right", -0.18))
    ]


def run(engine, seconds, **powers):
    """Run the world and return how far the robot turned meanwhile."""
    turned, before = 0.0, engine.pose().yaw_rad
    for _ in range(round(seconds / STEP_S)):
        engine.drive(powers, STEP_S)
        now = engine.pose().yaw_rad
        turned += (now - before + pi) % (2 * pi) - pi
        before = now
    return turned


def test_four_wheels_on_two_motors_drive_straight_and_stop():
    engine = Engine(WORLD, (), four(lambda place, side: side))
    run(engine, 2.0, left=0.5, right=0.5)
    pose = engine.pose()
    assert 0.6 < pose.x_m < 0.85
    assert abs(pose.y_m) < 0.01
    run(engine, 1.0, left=0.0, right=0.0)
    assert abs(engine.pose().speed_mps) < 0.01


def test_every_motor_moves_its_own_wheels_and_measures_them():
    engine = Engine(WORLD, (), four(lambda place, side: f"{place}_{side}"))
    run(engine, 1.0, front_left=-0.3, rear_left=-0.3, front_right=0.3, rear_right=0.3)
    motors = engine.sensed().motors
    assert motors["front_left"].counts < 0 < motors["rear_right"].counts
    assert engine.pose().turn_rps > 0.2
    assert engine.sensed().counts == (0, 0), "there are no motors of these names"


@pytest.mark.parametrize(
    "powers", [{"left": -0.3, "right": 0.3}, {"left": 0.1, "right": 0.4}, {"left": 0.3, "right": 0.3}]
)
def test_by_its_wheels_alone_the_odometry_of_a_slipping_base_is_near_the_truth(powers):
    wheels = four(lambda place, side: side)
    base = base_of([Kinematics(name="base", kind="skid", track_factor=FACTOR)], wheels, 0.27)
    engine, reckoning = Engine(WORLD, (), wheels), Reckoning(OdometrySettings(counts_per_turn=400.0), "test", base)
    turned, now = 0.0, 0.0
    for _ in range(100):
        left, right = engine.sensed().counts
        state = MotorsState(
            left=0.0, right=0.0, armed=True, reason="", estop=False, counts_left=left, counts_right=right
        )
        reckoning.count(state, now)
        turned += run(engine, STEP_S, **powers)
        now += STEP_S
    found = reckoning.state()
    assert found.valid
    assert found.yaw_rad == pytest.approx(turned, rel=0.15, abs=0.03)
    if powers["left"] == powers["right"]:
        assert found.x_m == pytest.approx(engine.pose().x_m, abs=0.03)


ARM = pi / 4
MECANUM = [replace(wheel, roller_rad=-ARM if wheel.x_m * wheel.y_m > 0 else ARM) for wheel in four("{}_{}".format)]
STAR = [
    Wheel(name=f"w{n}", motor=f"w{n}", x_m=0.18 * cos(a), y_m=0.18 * sin(a), yaw_rad=a + pi / 2, diameter_m=0.1)
    for n, a in enumerate((0.0, 2 * pi / 3, 4 * pi / 3))
]
TWISTS = [(0.3, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 0.8), (0.2, -0.2, 0.0), (-0.1, 0.1, -0.5)]


@pytest.mark.parametrize("twist", TWISTS)
@pytest.mark.parametrize(("kind", "wheels"), [("mecanum", MECANUM), ("omni", STAR)])
def test_a_base_on_rollers_moves_as_its_kinematics_say(kind, wheels, twist):
    base = base_of([Kinematics(name="base", kind=kind)], wheels, 0.27)
    engine = Engine(WORLD, (), wheels, rollers=True)
    speeds = base.speeds(Twist(vx_mps=twist[0], vy_mps=twist[1], wz_rps=twist[2]))
    powers = {motor: speed / BODY.max_speed_mps for motor, speed in zip(base.motors, speeds, strict=True)}
    run(engine, 1.5, **powers)
    before, counts = engine.pose(), engine.sensed().motors
    turned = run(engine, 0.5, **powers)
    after, later = engine.pose(), engine.sensed().motors
    middle = before.yaw_rad + turned / 2
    east, north = (after.x_m - before.x_m) / 0.5, (after.y_m - before.y_m) / 0.5
    moved = cos(middle) * east + sin(middle) * north, cos(middle) * north - sin(middle) * east, turned / 0.5
    assert moved == pytest.approx(twist, abs=0.05)
    each = [
        (later[motor].counts - counts[motor].counts) / 400 * pi * wheels[0].diameter_m / 0.5 for motor in base.motors
    ]
    told = base.twist(each)
    assert (told.vx_mps, told.vy_mps, told.wz_rps) == pytest.approx(twist, abs=0.06)


def test_a_base_on_rollers_stands_when_its_motors_do():
    engine = Engine(WORLD, (), MECANUM, rollers=True)
    run(engine, 1.0, front_left=-0.3, front_right=0.3, rear_left=0.3, rear_right=-0.3)
    assert engine.pose().y_m > 0.05
    run(engine, 1.5)
    began = engine.pose().y_m
    run(engine, 0.5)
    assert engine.pose().y_m == pytest.approx(began, abs=0.005)
