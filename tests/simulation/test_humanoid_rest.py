"""A humanoid that stands is at rest: time passes without its physics, exactly until something is to move it."""

from types import SimpleNamespace

import numpy as np
import pytest

from lbr.simulation.humanoid.capability import HumanoidPhysics
from lbr.simulation.requests import HandRequest
from tests.models.uxa90 import robot as uxa90
from tests.simulation.humanoid_bench import drives, humanoid

TICK_S = 0.02


def standing(**settings):
    """An engine whose body has come to rest on its feet."""
    engine = humanoid(hand_s=0.1, **settings)
    for _ in range(round(8.0 / TICK_S)):
        engine.step(drives({}), TICK_S)
        if engine.resting:
            break
    assert engine.resting
    assert engine.pose().stands
    assert not engine.held
    return engine


def run(engine, driven, seconds, tick_s=TICK_S):
    for _ in range(round(seconds / tick_s)):
        engine.step(driven, tick_s)


def test_who_stands_comes_to_rest_and_time_and_battery_go_on():
    engine = standing()
    place, time_s, charge = engine.data.qpos.copy(), engine.time_s, engine.battery.charge
    run(engine, drives({}), 5.0)
    assert np.array_equal(engine.data.qpos, place)
    assert engine.time_s == pytest.approx(time_s + 5.0)
    assert engine.battery.charge < charge


def test_whoever_rests_feels_gravity_and_no_turn():
    engine = standing()
    readings = []
    for _ in range(200):
        engine.step(drives({}), TICK_S)
        readings.append(engine.imu())
    accel = np.array([one.accel_mps2 for one in readings]).mean(axis=0)
    moving = humanoid(hand_s=0.1)
    run(moving, drives({}), 1.5)
    gyro = np.array([one.gyro_rps for one in readings]).mean(axis=0)
    bias = np.array(moving.settings.imu.gyro_bias_rps)
    assert np.linalg.norm(accel - moving.settings.imu.accel_bias_mps2) == pytest.approx(9.81, abs=0.02)
    assert gyro == pytest.approx(bias, abs=2e-3)


@pytest.mark.parametrize("tick_s", [0.004, 0.04])
def test_an_order_ends_the_rest_with_the_step_it_comes_in_whatever_the_pace(tick_s):
    engine = standing()
    run(engine, drives({}), 2.0, tick_s)
    run(engine, drives({"left_elbow": -1.0}), 1.0, tick_s)
    assert engine.pose().joints["left_elbow"] == pytest.approx(-1.0, abs=0.15)
    again = standing()
    run(again, drives({}), 2.0)
    run(again, drives({"left_elbow": -1.0}), 1.0)
    assert engine.data.qpos == pytest.approx(again.data.qpos, abs=1e-6)


def test_whoever_is_pushed_over_falls_without_a_pause():
    engine = standing()
    engine.push(-0.7, 0.0)
    assert not engine.resting
    rested = []
    for _ in range(100):
        engine.step(drives({}), TICK_S)
        rested.append(engine.resting and engine.pose().upright)
    assert not engine.pose().upright
    assert not any(rested)


def test_a_hand_that_takes_a_limp_joint_ends_the_rest_and_another_begins_when_it_holds_still():
    engine = humanoid(stand=True)
    run(engine, {}, 3.0)
    assert engine.resting
    engine.grip.take(HandRequest(joint="left_elbow", angle_deg=-40.0))
    assert not engine.resting
    run(engine, {}, 5.0)
    assert engine.pose().joints["left_elbow"] == pytest.approx(np.radians(-40.0), abs=0.05)
    assert engine.resting


@pytest.mark.parametrize("act", ["pick_up", "turn", "put"])
def test_whatever_puts_it_elsewhere_ends_its_rest(act):
    engine = standing()
    given = {"turn": (0.0, 0.5, 0.0, 0.0), "put": ([0.0] * 18,)}
    getattr(engine, act)(*given.get(act, ()))
    assert not engine.resting


def test_whoever_waits_for_the_hand_to_open_does_not_rest():
    engine = humanoid(hand_s=6.0)
    run(engine, drives({}), 5.0)
    assert engine.held
    assert not engine.resting
    run(engine, drives({}), 2.0)
    assert not engine.held


def test_a_ball_passes_while_a_uxa90_rests_that_stands():
    robot = uxa90.Robot()
    robot.play(7, rest_s=12.0)
    assert robot.engine.resting
    assert robot.seen[-1].stands
    before = robot.engine.balls.middle("ball", robot.engine.time_s)
    robot.run(1.0)
    body = robot.engine.data.body("ball ball")
    assert tuple(body.xpos) == pytest.approx(robot.engine.balls.middle("ball", robot.engine.time_s), abs=0.02)
    assert tuple(body.xpos) != pytest.approx(before, abs=0.01)


def test_registers_that_want_something_else_end_the_rest_before_any_step():
    engine = standing()
    bus = Bus(drives({}))
    physics = HumanoidPhysics(engine, [bus], SimpleNamespace(running=False))
    assert physics.resting(0.0)
    bus.driven = drives({"left_elbow": -1.0})
    assert not physics.resting(0.0)
    bus.driven = drives({})
    assert physics.resting(0.0)
    physics.pick_up = True
    assert not physics.resting(0.0)


class Bus:
    """A servo bus whose registers say what the test wants."""

    name = "servo_bus"

    def __init__(self, driven):
        self.driven = driven

    def drives(self, _now):
        return self.driven

    def feel_servos(self, _felt, _supply_v, _now):
        pass
