"""Wheels on a Roboteq at the end of a real line: what the line itself adds. All else is in test_wheels_capability.py."""

import time

import pytest

from lbr.drivers.roboteq import KIND
from lbr.drivers.roboteq.capability import Roboteq
from lbr.errors import DeviceError
from lbr.messages.motors import MotorSetpoint
from tests.drivers.peers import DriverContext
from tests.support.waiting import STOPS_S, until

SETTINGS = '{"device": "motors", "guard": false, "reply_timeout_s": 0.1, "left": {"channel": 1, "direction": -1}, "right": {"channel": 2}}'
"""No guard: it would kill whoever runs these tests for standing still."""


def setpoint(left, right, lease="L1"):
    return MotorSetpoint(left=left, right=right, lease=lease)


@pytest.fixture
def ctx(peer):
    return DriverContext(KIND, KIND.parse(SETTINGS), peer.path, "roboteq")


@pytest.fixture
def motors(ctx):
    motors = KIND.load()(ctx)
    assert isinstance(motors, Roboteq)
    motors.open()
    yield motors
    motors.close()


@pytest.fixture
def drive(motors, ctx, peer):
    """Arms, then drives with fresh setpoints until the wheels turn."""

    def go(left=0.5, right=0.5, lease="L1"):
        ctx.give(setpoint(0.0, 0.0))
        motors.step()
        ctx.give(setpoint(left, right, lease))
        motors.step()

    return go


def moves(peer):
    return [line for line in peer.motor_commands() if line.startswith("!M ") and line != "!M 0 0"]


def test_an_emergency_stop_is_written_to_a_babbling_controller_and_never_called_done(drive, motors, ctx, peer):
    drive()
    peer.babble(b"junk\r" * 200)
    ctx.give(setpoint(0.4, 0.4))
    motors.step()
    ctx.estop.engaged = True
    began = time.monotonic()
    with pytest.raises(DeviceError, match="babbles"):
        until(motors.step)
    until(lambda: "!EX" in peer.log, what="the stop, which its thread reads")
    assert peer.times[peer.log.index("!EX")] - began < STOPS_S
    assert not any(stopped for stopped, _ in ctx.estop.acknowledged)


def test_unplugging_is_an_error_and_after_replugging_zero_comes_first_and_nothing_moves(drive, motors, ctx, peer):
    drive()
    peer.unplug()
    with pytest.raises(DeviceError, match=r"'motors'.*went away"):
        until(motors.step)
    motors.close()
    motors.degraded("unplugged")
    assert not ctx.state.armed
    assert ctx.state.reason == "unplugged"
    with pytest.raises(DeviceError, match="missing"):
        motors.open()
    motors.close()
    peer.log.clear()
    peer.settings["RWD"] = 1000
    peer.plug()
    motors.open()
    ctx.give(setpoint(0.5, 0.5))
    motors.step()
    assert peer.motor_commands()[0] == "!M 0 0"
    assert peer.settings["RWD"] == 200
    assert moves(peer) == []
    drive(0.5, 0.5, "L1")
    assert moves(peer) == []  # that lease died with the cable
    until(lambda: drive(0.5, 0.5, "L2") or peer.motor == (-500, 500))
