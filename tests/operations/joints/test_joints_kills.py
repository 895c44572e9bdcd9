"""Whatever is killed or hangs while a joint moves, the servos hold; after a time they let go, and nothing resumes."""

import signal
import tempfile
from pathlib import Path

import pytest

from tests.operations.joints.joints_stage import Stage
from tests.support.waiting import until


@pytest.fixture(scope="module")
def stage():
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        made = Stage(Path(place))
        yield made
        made.close()


@pytest.fixture
def moving(stage):
    stage.stand()
    yield stage
    stage.dismiss()


def held(stage):
    """Where the knee is told to be, which is where it is, give or take what a servo lags behind."""
    here, goal, torque = stage.twin.joint("left_knee")
    assert torque > 0.0
    assert goal == pytest.approx(here, abs=0.1)
    return goal


def test_a_stop_is_the_end_of_the_motion_for_every_servo(moving):
    moving.ask("joints/stop", {"reason": "test"})
    goal = held(moving)
    state = moving.heard("joints/state", moving=False, phase="following")
    assert state["reason"] == "stopped by test: test"
    assert moving.ask("servos/state")["halt"] > 0
    assert held(moving) == pytest.approx(goal, abs=0.02)


def test_a_killed_client_leaves_the_servos_holding_and_then_they_let_go(moving):
    moving.dismiss()
    state = moving.heard("joints/state", moving=False, phase="holding")
    assert "lapsed" in state["reason"]
    goal = held(moving)
    until(lambda: moving.twin.joint("left_knee")[2] == 0.0)
    assert moving.twin.joint("left_knee")[1] == pytest.approx(goal, abs=0.02)
    moving.heard("joints/state", phase="released")
    refused = moving.ask("joints/command", {"positions": {"left_knee": -0.3}})
    assert (refused["code"], refused["reason"].split()[0]) == ("no_torque", "left_knee")


def test_killed_joints_leave_the_servos_holding_and_a_new_process_moves_nothing(moving):
    moving.kill("joints")
    moving.reap("joints")
    moving.heard("servos/state", phase="holding")
    goal = held(moving)
    moving.start("joints")
    until(lambda: (moving.state() or {}).get("sequence"))
    until(lambda: moving.knee["torque"] is not None)
    _, after, torque = moving.twin.joint("left_knee")
    assert after == pytest.approx(goal, abs=0.02) or torque == 0.0
    assert not moving.state()["moving"]


def test_joints_that_hang_leave_the_servos_holding_and_going_on_resumes_nothing(moving):
    moving.kill("joints", signal.SIGSTOP)
    moving.heard("servos/state", phase="holding")
    goal = held(moving)
    moving.kill("joints", signal.SIGCONT)
    state = moving.heard("joints/state", moving=False)
    assert state["holder"] is None
    _, after, torque = moving.twin.joint("left_knee")
    assert after == pytest.approx(goal, abs=0.02) or torque == 0.0


def test_a_killed_driver_ends_the_motion_and_its_successor_moves_nothing_and_lets_nothing_fall(moving):
    moving.kill("servos")
    moving.reap("servos")
    state = moving.heard("joints/state", moving=False)
    assert state["reason"] == "the servo driver (servos) is gone"
    goal = held(moving)
    moving.start("servos")
    moving.heard("joints/state", phase="following")
    assert held(moving) == pytest.approx(goal, abs=0.02)
    assert moving.twin.joint("right_knee")[2] > 0.0
