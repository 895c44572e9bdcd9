"""The simulated world against what a ruler, a stopwatch and an ammeter would say."""

from math import cos, pi

import pytest

from lbr.simulation.engine import Engine
from lbr.simulation.messages import WorldBox
from lbr.simulation.settings import Battery, BoxSettings, StartPose, Ultrasonic, WorldSettings

WALL = BoxSettings(name="wall", x_m=2.0, y_m=0.0, length_m=0.1, width_m=8.0)
WALL_FACE_M = 1.95
HALF_LENGTH_M = 0.215


def world(**settings):
    return Engine(WorldSettings(**{"walls": (), **settings}))


def drive(engine, left, right, seconds):
    for _ in range(round(seconds / 0.02)):
        engine.step(left, right, 0.02)
    return engine.pose()


def test_half_power_travels_half_a_metre_a_second_after_the_ramp():
    engine = world()
    pose = drive(engine, 0.5, 0.5, 2.0)
    assert pose.x_m == pytest.approx(0.5 * 2 - 0.5**2 / 2 / 1.2, abs=0.02)
    assert pose.speed_mps == pytest.approx(0.5, abs=0.01)
    assert abs(pose.y_m) < 0.005
    left, right = engine.sensed().counts
    assert left == right == pytest.approx(pose.x_m / (pi * 0.1778) * 130, abs=1.5)


def test_standing_still_it_stands_still():
    pose = drive(world(), 0.0, 0.0, 3.0)
    assert (pose.x_m, pose.y_m, pose.yaw_rad) == pytest.approx((0, 0, 0), abs=1e-3)


def test_it_comes_to_rest_when_the_power_ends():
    engine = world()
    moving = drive(engine, 0.5, 0.5, 2.0)
    pose = drive(engine, 0.0, 0.0, 0.5)
    assert abs(pose.speed_mps) < 0.005
    assert pose.x_m - moving.x_m == pytest.approx(0.5**2 / 2 / 2.5, abs=0.02)


def test_a_faster_right_wheel_turns_it_left():
    pose = drive(world(), -0.2, 0.2, 1.0)
    assert pose.turn_rps > 1
    assert pose.yaw_rad > 0.9


@pytest.mark.parametrize("yaw", [0.0, 0.15])
def test_the_forward_range_is_the_distance_to_the_wall(yaw):
    engine = world(walls=(WALL,), start=StartPose(yaw_rad=yaw), ultrasonic=Ultrasonic(noise_m=0.008))
    seen = []
    for _ in range(100):
        engine.step(0, 0, 0.04)
        seen.append(engine.sensed().ranges_m["forward"])
    expected = WALL_FACE_M - HALF_LENGTH_M * cos(yaw)
    assert all(abs(value - expected) < 0.05 for value in seen)
    assert sum(seen) / len(seen) == pytest.approx(expected, abs=0.004)
    assert len(set(seen)) > 50
    assert engine.sensed().ranges_m["back"] is None


def test_each_side_looks_its_own_way():
    boxes = (
        BoxSettings(name="ahead", x_m=1.5, y_m=0, length_m=0.2, width_m=2),
        BoxSettings(name="left", x_m=0, y_m=1.0, length_m=2, width_m=0.2),
        BoxSettings(name="right", x_m=0, y_m=-2.0, length_m=2, width_m=0.2),
        BoxSettings(name="behind", x_m=-3.0, y_m=0, length_m=0.2, width_m=2),
    )
    ranges = world(walls=boxes, ultrasonic=Ultrasonic(noise_m=0.0)).sensed().ranges_m
    assert ranges == pytest.approx({"forward": 1.185, "left": 0.75, "right": 1.75, "back": 2.685}, abs=1e-6)


def test_a_thin_post_beside_the_axis_is_seen_by_the_cone():
    post = BoxSettings(name="post", x_m=1.5, y_m=0.15, length_m=0.1, width_m=0.1)
    assert world(walls=(post,)).sensed().ranges_m["forward"] is not None


def test_a_wall_stops_it_and_touching_says_so():
    engine = world(walls=(WALL,))
    assert not engine.touching()
    pose = drive(engine, 0.8, 0.8, 4.0)
    assert pose.touching
    assert pose.x_m == pytest.approx(WALL_FACE_M - HALF_LENGTH_M, abs=0.02)
    assert abs(pose.speed_mps) < 0.05
    pose = drive(engine, -0.5, -0.5, 1.0)
    assert not pose.touching


def test_currents_rise_with_work_and_most_against_a_wall():
    engine = world(walls=(WALL,))
    drive(engine, 0.5, 0.5, 0.2)
    starting = engine.sensed().amps_a[0]
    drive(engine, 0.5, 0.5, 1.0)
    cruising = engine.sensed().amps_a[0]
    drive(engine, 0.5, 0.5, 4.0)
    assert 0.3 < cruising < starting < engine.sensed().amps_a[0] < 30
    drive(engine, -0.5, -0.5, 1.0)
    assert engine.sensed().amps_a[0] < 0


def test_the_battery_sags_under_load_and_recovers():
    engine = world(walls=(WALL,), battery=Battery(internal_ohm=0.1))
    rest_v = engine.battery.voltage_v
    drive(engine, 1.0, 1.0, 4.0)
    assert engine.battery.voltage_v < rest_v - 0.5
    assert engine.battery.charge < 1.0
    drive(engine, 0.0, 0.0, 2.0)
    assert engine.battery.voltage_v == pytest.approx(rest_v, abs=0.05)


def run(seed):
    engine = Engine(WorldSettings(seed=seed))
    drive(engine, 0.6, 0.4, 3.0)
    return engine.pose(), dict(engine.sensed().ranges_m), engine.sensed().counts


def test_the_same_seed_gives_the_same_run():
    assert run(7) == run(7)
    assert run(7) != run(8)


@pytest.mark.parametrize("power", [float("nan"), float("inf"), float("-inf")])
def test_a_power_that_is_no_number_moves_nothing(power):
    assert drive(world(), power, power, 0.5).speed_mps == pytest.approx(0, abs=1e-3)


def test_time_is_kept_whatever_the_pieces():
    engine = world()
    for _ in range(1000):
        engine.step(0, 0, 0.0013)
    assert engine.time_s == pytest.approx(1.3, abs=0.004)


def test_the_default_room_has_walls_round_the_robot():
    engine = Engine(WorldSettings())
    assert all(value is not None and 1 < value < 6 for value in engine.sensed().ranges_m.values())
    names = [box.name for box in engine.scene().walls]
    assert len(set(names)) == len(names)
    assert {"north wall", "table", "chair leg 1", "rug"} <= set(names)


def test_at_rest_time_passes_without_physics_and_power_finds_everything_as_it_was():
    restless, rested = world(seed=3), world(seed=3)
    rested.drive({}, 600.0)
    assert rested.resting
    assert rested.time_s == pytest.approx(600.0, abs=0.01)
    assert rested.battery.charge < restless.battery.charge
    went, later = drive(restless, 0.5, 0.3, 1.0), drive(rested, 0.5, 0.3, 1.0)
    assert not rested.resting
    assert (later.x_m, later.y_m, later.yaw_rad) == pytest.approx((went.x_m, went.y_m, went.yaw_rad), abs=1e-5)
    assert drive(rested, 0.0, 0.0, 3.0).speed_mps == pytest.approx(0.0, abs=1e-6)
    assert rested.resting


def test_what_is_measured_at_rest_has_its_noise_and_what_appears_is_seen():
    engine = world(walls=(WALL,), ultrasonic=Ultrasonic(noise_m=0.01))
    engine.drive({}, 1.0)
    seen = set()
    for _ in range(5):
        engine.drive({}, 0.04)
        seen.add((engine.ranges_m["forward"], engine.imu().gyro_rps))
    assert engine.resting
    assert len({range_m for range_m, _ in seen}) == len({turn for _, turn in seen}) == 5
    assert all(range_m == pytest.approx(WALL_FACE_M - HALF_LENGTH_M, abs=0.1) for range_m, _ in seen)
    engine.place(WorldBox(name="box", x_m=1.0, y_m=0.0, length_m=0.2, width_m=0.6, height_m=0.6))
    engine.drive({}, 0.1)
    assert engine.ranges_m["forward"] == pytest.approx(0.9 - HALF_LENGTH_M, abs=0.1)
