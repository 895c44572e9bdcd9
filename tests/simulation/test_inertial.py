"""The inertial unit against gravity, the earth's field, a stopwatch and a turntable."""

from math import cos, pi, radians, sin

import pytest

from lbr.simulation.engine import Engine
from lbr.simulation.settings import Compass, Imu, Mount, StartPose, WorldSettings

PERFECT = Imu(
    gyro_bias_rps=(0.0, 0.0, 0.0),
    gyro_noise_rps=0.0,
    accel_bias_mps2=(0.0, 0.0, 0.0),
    accel_noise_mps2=0.0,
    hard_iron_ut=(0.0, 0.0, 0.0),
    soft_iron=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    mag_noise_ut=0.0,
)
LEVEL_UT, DOWN_UT = 48.0 * cos(radians(65)), 48.0 * sin(radians(65))


def perfect(**changes):
    return Imu(**{**{name: getattr(PERFECT, name) for name in PERFECT.__struct_fields__}, **changes})


def world(imu=PERFECT, **settings):
    return Engine(WorldSettings(walls=(), dock=None, imu=imu, **settings))


def averaged(engine, left, right, seconds):
    """Drive, and return the averages of gyro and accelerometer at each step."""
    readings = []
    for _ in range(round(seconds / 0.004)):
        engine.step(left, right, 0.004)
        readings.append(engine.imu())
    return [
        tuple(sum(getattr(one, name)[axis] for one in readings) / len(readings) for axis in range(3))
        for name in ("gyro_rps", "accel_mps2")
    ]


def test_at_rest_it_measures_gravity_and_no_turn():
    engine = world()
    for reading in (engine.imu(), (engine.step(0, 0, 1.0), engine.imu())[1]):
        assert reading.accel_mps2 == pytest.approx((0, 0, 9.81), abs=0.01)
        assert reading.gyro_rps == pytest.approx((0, 0, 0), abs=1e-3)


def test_it_measures_the_turn_that_the_body_makes():
    engine = world()
    engine.step(-0.05, 0.05, 1.0)
    gyro, _ = averaged(engine, -0.05, 0.05, 1.0)
    assert gyro == pytest.approx((0, 0, engine.pose().turn_rps), abs=0.01)
    assert gyro[2] > 0.2


def test_speeding_up_pushes_ahead():
    engine = world()
    _, accel = averaged(engine, 0.5, 0.5, 0.3)
    assert accel[0] == pytest.approx(1.2, abs=0.2)
    assert accel[1] == pytest.approx(0.0, abs=0.05)


def test_its_axes_are_those_of_its_mount():
    engine = world(perfect(mount=Mount(yaw_deg=90.0)))
    _, accel = averaged(engine, 0.5, 0.5, 0.3)
    assert accel[1] == pytest.approx(-1.2, abs=0.2)
    tilted = world(perfect(mount=Mount(roll_deg=180.0))).imu()
    assert tilted.accel_mps2 == pytest.approx((0, 0, -9.81), abs=0.01)
    assert tilted.mag_ut == pytest.approx((LEVEL_UT, 0, DOWN_UT), abs=0.1)
    nose_down = world(perfect(mount=Mount(pitch_deg=90.0))).imu()
    assert nose_down.accel_mps2 == pytest.approx((-9.81, 0, 0), abs=0.01)


@pytest.mark.parametrize(
    ("yaw", "north_deg", "expected"),
    [
        (0.0, 0.0, (LEVEL_UT, 0.0)),
        (pi / 2, 0.0, (0.0, -LEVEL_UT)),
        (0.0, 90.0, (0.0, LEVEL_UT)),
        (pi / 2, 90.0, (LEVEL_UT, 0.0)),
    ],
)
def test_the_compass_points_north_and_down(yaw, north_deg, expected):
    field = world(start=StartPose(yaw_rad=yaw), compass=Compass(north_deg=north_deg)).imu().mag_ut
    assert field == pytest.approx((*expected, -DOWN_UT), abs=0.1)


def test_iron_shifts_and_squeezes_the_circle():
    iron = perfect(hard_iron_ut=(10.0, -20.0, 5.0), soft_iron=((2.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, 1.0)))
    fields = [world(iron, start=StartPose(yaw_rad=yaw)).imu().mag_ut for yaw in (0.0, pi / 2, pi, -pi / 2)]
    along, aside = [field[0] for field in fields], [field[1] for field in fields]
    assert (max(along) - min(along), max(aside) - min(aside)) == pytest.approx((4 * LEVEL_UT, LEVEL_UT), abs=0.2)
    assert (max(along) + min(along), max(aside) + min(aside)) == pytest.approx((20.0, -40.0), abs=0.2)


def test_noise_and_bias_are_those_of_the_settings():
    engine = world(perfect(gyro_bias_rps=(0.1, -0.2, 0.3), gyro_noise_rps=0.02, mag_noise_ut=1.0))
    gyro, field = [], []
    for _ in range(1000):
        engine.step(0, 0, 0.004)
        gyro.append(engine.imu().gyro_rps[1])
        field.append(engine.imu().mag_ut[0])
    mean = sum(gyro) / len(gyro)
    assert mean == pytest.approx(-0.2, abs=0.003)
    assert (sum((one - mean) ** 2 for one in gyro) / len(gyro)) ** 0.5 == pytest.approx(0.02, rel=0.1)
    assert (sum((one - LEVEL_UT) ** 2 for one in field) / len(field)) ** 0.5 == pytest.approx(1.0, rel=0.1)


def run(seed, reads):
    engine = Engine(WorldSettings(seed=seed))
    for step in range(300):
        engine.step(0.3, 0.2, 0.004)
        for _ in range(reads * (step % 3)):
            engine.imu()
    return engine.imu(), engine.ranges_m, engine.pose()


def test_whoever_reads_it_changes_nothing_for_others():
    assert run(3, 0) == run(3, 5)
    assert run(3, 0) != run(4, 0)


def test_the_cameras_turn_with_the_robot():
    ahead, turned = world(), world(start=StartPose(x_m=1.0, yaw_rad=pi / 2))
    at, looks = _camera(ahead, "front")
    assert (at[0], at[2]) == pytest.approx((0.06, 1.25), abs=0.002)
    assert looks == pytest.approx((cos(radians(12)), 0, -sin(radians(12))), abs=0.01)
    at, _ = _camera(turned, "front")
    assert (at[0], at[1]) == pytest.approx((1.0, 0.06), abs=0.002)
    _, looks = _camera(turned, "rear")
    assert looks == pytest.approx((0, -cos(radians(12)), -sin(radians(12))), abs=0.01)


def _camera(engine, name):
    """Where a camera of the model is, and the way it looks: against its own z."""
    found = engine._data.camera(name)
    return tuple(map(float, found.xpos)), tuple(-float(value) for value in found.xmat.reshape(3, 3)[:, 2])
