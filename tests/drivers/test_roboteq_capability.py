import time
from math import nan

import pytest

from lbr.bus.stamp import boot_id
from lbr.drivers.roboteq import KIND
from lbr.drivers.roboteq.capability import Roboteq
from lbr.drivers.roboteq.controller import Controller
from lbr.drivers.wheels import EnableCommand, capability
from lbr.drivers.wheels.arming import START, Setpoint, receive
from lbr.errors import DeviceError
from lbr.messages.motors import MotorSetpoint
from lbr.messages.system import Stamp
from lbr.testing import FakeCall
from tests.drivers.peers import DriverContext
from tests.support.waiting import STOPS_S, until

SETTINGS = '{"device": "motors", "guard": false, "left": {"channel": 1, "direction": -1}, "right": {"channel": 2}}'
"""No guard: it would kill whoever runs these tests for standing still."""


def setpoint(left, right, lease="L1"):
    return MotorSetpoint(left=left, right=right, lease=lease)


def stamp(age_s, boot):
    return Stamp(source="drive", seq=1, mono_ns=time.monotonic_ns() - int(age_s * 1e9), wall_ns=0, boot=boot)


@pytest.fixture
def ctx(peer):
    ctx = DriverContext(KIND, KIND.parse(SETTINGS), peer.path, "roboteq", peer)
    ctx.clock = peer.clock
    return ctx


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


def test_a_zero_arms_and_then_setpoints_turn_the_wheels(drive, ctx, peer):
    drive(0.2, -0.2)
    assert peer.motor == (-200, -200)
    assert ctx.state.armed
    assert (ctx.state.left, ctx.state.right) == (0.2, -0.2)
    assert ctx.state.reason == ""


def test_after_opening_a_power_without_a_zero_before_it_moves_nothing(motors, ctx, peer):
    for _ in range(5):
        ctx.give(setpoint(0.5, 0.5))
        motors.step()
    assert moves(peer) == []
    assert not ctx.state.armed
    assert ctx.state.reason == START


def test_silence_of_the_source_stops_the_wheels_within_a_tenth_of_a_second_and_kills_the_lease(
    drive, motors, ctx, peer
):
    drive()
    began = time.monotonic()
    until(lambda: (motors.step(), peer.motor == (0, 0))[1])
    assert time.monotonic() - began > 0.08
    assert ctx.kinds() == ["trip"]
    assert ctx.state.trips == 1
    drive(0.5, 0.5, "L1")
    assert peer.motor == (0, 0)
    drive(0.5, 0.5, "L2")
    assert peer.motor == (-500, 500)


@pytest.mark.parametrize(
    ("age_s", "boot", "moving"),
    [(0.0, "here", True), (0.5, "here", False), (0.5, "elsewhere", True), (0.5, "", True)],
)
def test_a_stamp_of_this_boot_tells_a_setpoint_that_was_long_on_its_way(motors, ctx, peer, age_s, boot, moving):
    ctx.give(setpoint(0.0, 0.0))
    motors.step()
    ctx.give(setpoint(0.5, 0.5), stamp=stamp(age_s, boot_id() if boot == "here" else boot))
    motors.step()
    assert (peer.motor != (0, 0)) is moving


def test_a_zero_from_before_the_driver_began_does_not_arm_it(ctx):
    before = ctx.clock()
    begun = KIND.load()(ctx)._arming
    now = ctx.clock()
    assert not receive(begun, Setpoint((0.0, 0.0), "", before), now, valid_s=10.0).armed
    assert receive(begun, Setpoint((0.0, 0.0), "", now + 0.001), now, valid_s=10.0).armed


def test_setpoints_from_anyone_but_the_wired_source_are_ignored(motors, ctx, peer):
    ctx.give(setpoint(0.0, 0.0), source="stranger")
    motors.step()
    assert not ctx.state.armed


def test_the_death_of_the_source_stops_at_once(drive, motors, ctx, peer):
    drive()
    ctx.gone.add("drive")
    motors.step()
    assert peer.motor == (0, 0)
    assert "'drive' is not on the bus" in ctx.state.reason
    assert ctx.kinds() == ["trip"]


def test_no_wired_source_never_arms(motors, ctx):
    ctx.wired["setpoint"] = ()
    ctx.give(setpoint(0.0, 0.0))
    motors.step()
    assert not ctx.state.armed
    assert "wired" in ctx.state.reason


def test_a_power_that_is_no_number_stops_the_wheels(drive, motors, ctx, peer):
    drive()
    ctx.give(setpoint(nan, 0.5))
    until(lambda: (motors.step(), peer.motor)[1] == (0, 0))
    assert not ctx.state.armed
    assert ctx.state.trips == 1


def test_an_emergency_stop_is_acknowledged_only_with_the_controllers_word(drive, motors, ctx, peer, wording):
    drive()
    peer.answer = lambda line: b"!EX\r" if line == "!EX" else None
    ctx.estop.engaged, ctx.estop.reason = True, "button"
    motors.step()
    assert peer.motor == (0, 0)
    ((stopped, why),) = ctx.estop.acknowledged
    assert not stopped
    wording(why)
    peer.answer = lambda line: None
    motors.step()
    assert ctx.estop.acknowledged[-1] == (True, "")
    assert ctx.state.estop
    assert ctx.state.reason == "emergency stop: button"


def test_release_zeroes_first_and_moves_nothing_until_a_new_zero(drive, motors, ctx, peer):
    drive()
    ctx.estop.engaged = True
    motors.step()
    peer.log.clear()
    ctx.estop.engaged = False
    for _ in range(4):
        ctx.give(setpoint(0.5, 0.5))
        motors.step()
    assert peer.motor_commands()[:2] == ["!M 0 0", "!MG"]
    assert not peer.latched
    assert moves(peer) == []
    assert not ctx.state.armed
    drive(0.3, 0.3, "L2")
    assert peer.motor == (-300, 300)


def test_a_latch_that_the_controller_lost_is_set_again(motors, ctx, peer):
    ctx.estop.engaged = True
    motors.step()
    peer.latched, peer.answers["FF"] = False, "0"
    until(lambda: (motors.step(), peer.latched)[1])


def test_a_latch_engaged_before_opening_is_set_on_the_controller(ctx, peer):
    ctx.estop.engaged = True
    motors = Roboteq(ctx)
    motors.open()
    motors.step()
    assert peer.latched
    motors.close()


def test_the_controllers_own_emergency_stop_is_reported_and_ended_by_stop_and_reset(drive, motors, ctx, peer):
    drive()
    peer.latched, peer.answers["FF"] = True, "16"
    until(lambda: (ctx.give(setpoint(0.5, 0.5)), motors.step(), not ctx.state.armed)[2])
    motors.step()
    assert "not by this robot" in ctx.state.reason
    assert ctx.state.faults == ("emergency_stop",)
    assert any(phase != "ready" for phase in ctx.health)
    ctx.estop.engaged = True
    motors.step()
    ctx.estop.engaged = False
    until(lambda: (motors.step(), not peer.latched)[1])
    drive(0.1, 0.1, "L2")
    assert peer.motor == (-100, 100)


@pytest.mark.parametrize(("bits", "name"), [(1, "overheat"), (4, "undervoltage"), (8, "short_circuit"), (64, "mosfet")])
def test_a_fault_disarms_and_is_named(drive, motors, ctx, peer, bits, name):
    drive()
    peer.answers["FF"] = str(bits)
    until(lambda: (ctx.give(setpoint(0.5, 0.5)), motors.step(), peer.motor == (0, 0) and not ctx.state.armed)[2])
    assert name in ctx.state.reason
    assert ctx.state.faults == (name,)
    assert "fault" in ctx.kinds()
    peer.answers["FF"] = "0"
    until(lambda: (motors.step(), ctx.state.reason == START)[1])
    assert ctx.health[-1] == "ready"


def test_a_tolerated_fault_is_shown_but_does_not_disarm(drive, motors, ctx, peer):
    peer.answers["FF"] = "128"
    until(lambda: (motors.step(), ctx.state.faults == ("default_configuration",))[1])
    drive()
    assert peer.motor == (-500, 500)


def test_disabling_execution_stops_and_enabling_waits_for_a_zero(drive, motors, ctx, peer):
    drive()
    off, on = (FakeCall("enable", EnableCommand(enabled=enabled)) for enabled in (False, True))
    motors.command(off)
    motors.step()
    assert peer.motor == (0, 0)
    assert ctx.state.reason == "execution is disabled"
    drive(0.5, 0.5, "L2")
    assert peer.motor == (0, 0)
    motors.command(on)
    ctx.give(setpoint(0.5, 0.5, "L3"))
    motors.step()
    assert (peer.motor, on.answer) == ((0, 0), None)
    drive(0.5, 0.5, "L3")
    assert peer.motor == (-500, 500)
    assert [call.answer.accepted for call in (off, on)] == [True, True]


def test_what_a_ramp_came_to_while_the_controller_took_nothing_is_not_sent_at_once(
    drive, motors, ctx, peer, monkeypatch, wording
):
    drive(0.01, 0.01)
    with monkeypatch.context() as late:  # as when answers come too late for three commands, and no more
        late.setattr(Controller, "fed_s_ago", 0.12)
        ctx.give(setpoint(0.4, 0.4))
        motors.step()
    wording(ctx.state.reason)
    ctx.give(setpoint(0.4, 0.4))
    motors.step()
    assert peer.motor == (0, 0)
    drive(0.4, 0.4, "L2")
    assert peer.motor == (-400, 400)


@pytest.mark.parametrize("noise", [b"junk\r" * 200, b"\xff" * 1000])
def test_every_step_ends_before_a_babbling_controller_does(drive, motors, ctx, peer, noise):
    drive()
    peer.babble(noise)
    steps = []

    def step():
        began = time.monotonic()
        try:
            motors.step()
        finally:
            steps.append(time.monotonic() - began)

    with pytest.raises(DeviceError, match=r"babbles .* unanswered"):
        until(lambda: (ctx.give(setpoint(0.5, 0.5)), step())[1])
    assert max(steps) < 1.0


def test_an_emergency_stop_is_written_to_a_babbling_controller_and_never_called_done(drive, motors, ctx, peer):
    drive()
    peer.babble(b"junk\r" * 200)
    ctx.give(setpoint(0.4, 0.4))
    motors.step()
    ctx.estop.engaged = True
    began = time.monotonic()
    with pytest.raises(DeviceError, match="babbles"):
        until(motors.step)
    assert peer.times[peer.log.index("!EX")] - began < STOPS_S
    assert not any(stopped for stopped, _ in ctx.estop.acknowledged)


def test_closing_while_moving_writes_zero_within_fifty_milliseconds(drive, motors, peer):
    drive()
    motors.close()
    assert peer.motor == (0, 0)


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
    drive(0.5, 0.5, "L2")
    assert peer.motor == (-500, 500)


def test_while_away_an_emergency_stop_is_answered_with_the_truth(motors, ctx, peer):
    peer.unplug()
    motors.close()
    ctx.estop.engaged = True
    motors.degraded("unplugged")
    assert ctx.estop.acknowledged == [(False, "unplugged")]
    assert ctx.state.estop


def test_unanswered_commands_are_reported(drive, motors, ctx, peer, monkeypatch):
    monkeypatch.setattr(capability, "FEW", 2)
    drive()
    counted = []
    peer.answer = lambda line: b"" if line == "!M -500 500" and len(counted) < 2 and not counted.append(line) else None
    until(lambda: (ctx.give(setpoint(0.5, 0.5)), motors.step(), "unanswered" in ctx.kinds())[2])
    assert ctx.state.armed
