"""A ball in a room: seen by the cameras and from above, and by nothing else."""

import pytest

from lbr.simulation.balls import Ball
from lbr.simulation.cameras.studio import Studio
from lbr.simulation.cameras.view import SharedView
from lbr.simulation.devices.camera import CameraFaults
from lbr.simulation.engine import Engine
from lbr.simulation.messages import WorldBox
from lbr.simulation.physics import unpacked
from lbr.simulation.requests import BallRequest
from lbr.simulation.settings import WorldSettings
from tests.simulation.camera_bench import orange
from tests.simulation.world_bench import Bench

ONE = {"x_m": 1.0, "y_m": 0.0, "z_m": 0.3}


def at_rest(engine):
    for _ in range(100):
        engine.step(0.0, 0.0, 0.04)
        if engine.resting:
            return True
    return False


def driven(engine):
    engine.step(0.4, 0.4, 3.0)
    pose = engine.pose()
    return pose.x_m, pose.y_m, pose.yaw_rad, engine.ranges_m, engine.touching()


def test_it_is_not_there_until_it_is_put_and_a_world_at_rest_stays_so():
    engine = Engine(WorldSettings())
    assert at_rest(engine)
    before = engine.view()
    assert not [box for box in engine.scene().walls if box.name == "ball"]
    engine.balls.put(BallRequest(**ONE))
    assert not engine.resting
    assert at_rest(engine)
    there = engine.view()
    assert there != before
    engine.step(0.0, 0.0, 1.0)
    assert (engine.resting, engine.view()) == (True, there)
    engine.balls.put(BallRequest())
    assert at_rest(engine)
    assert engine.view() != there
    assert engine.scene() == Engine(WorldSettings()).scene()


def test_neither_ranges_nor_motion_know_of_it():
    plain, other = Engine(WorldSettings()), Engine(WorldSettings())
    other.balls.put(BallRequest(**ONE))
    assert driven(other) == driven(plain)
    assert other.pose().x_m > 1.0


def test_one_on_a_path_keeps_the_world_moving():
    engine = Engine(WorldSettings(balls={"ball": Ball(path="circle")}))
    assert not at_rest(engine)
    engine.balls.put(BallRequest(**ONE))
    assert at_rest(engine)


@pytest.mark.parametrize("use_gl", [True, False])
def test_the_front_camera_sees_it_where_it_is_put(use_gl):
    engine = Engine(WorldSettings(walls=(), dock=None))
    view = SharedView(len(engine.view()))
    studio = Studio(unpacked(engine.packed()), view, use_gl=use_gl)
    seen = []
    for y_m in (0.3, -0.3, None):
        engine.balls.put(BallRequest(x_m=1.2, y_m=y_m, gone=y_m is None))
        engine.step(0.0, 0.0, 0.1)
        view.write(engine.view(), round(engine.time_s * 1e9))
        studio.newest_ns()
        seen.append(orange(studio.picture("front_camera", "front", (320, 180), CameraFaults())))
    left, right, gone = seen
    assert left[0] < -0.1
    assert right[0] > 0.1
    assert gone is None
    studio.close()
    view.close()


def test_the_world_puts_it_and_shows_it_from_above(tmp_path):
    bench = Bench(tmp_path, walls=())
    bench.world.open()
    assert "there is no ball 'moon'" in bench.ask("ball", BallRequest(name="moon")).refused
    assert bench.ask("ball", BallRequest(x_m=1.2, y_m=0.4)).answer.reason == "'ball' is at 1.20, 0.40, 1.00 m"
    assert bench.until(lambda: [box.name for box in bench.ctx.said("scene")[-1].walls] == ["ball"])
    box: WorldBox = bench.ctx.said("scene")[-1].walls[0]
    assert (box.x_m, box.y_m, box.solid, box.kind, box.length_m) == (1.2, 0.4, False, "cylinder", 0.14)
    assert bench.ask("ball", BallRequest(gone=True)).answer.accepted
    assert bench.until(lambda: not bench.ctx.said("scene")[-1].walls)
    bench.world.close()
