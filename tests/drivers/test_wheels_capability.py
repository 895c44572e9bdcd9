"""What holds wheels and what tells of it, in virtual time down to the bytes for an emulated controller."""

from itertools import pairwise
from math import ceil

import pytest
from msgspec.structs import replace

from lbr.drivers.roboteq.controller import Controller
from lbr.drivers.wheels import EnableCommand, capability
from lbr.drivers.wheels.arming import START, Setpoint, receive
from lbr.drivers.wheels.capability import GUARD_STARTS
from lbr.errors import DeviceError
from lbr.messages.kinematics import Kinematics, Wheel
from lbr.messages.leases import StopCommand
from lbr.messages.motors import MotorSetpoint
from lbr.testing import FakeCall, FakeContext
from tests.drivers.tiny_wheels import FOUR, QUAD, STOP_FOUR, Quad, TinyController
from tests.drivers.wheel_line import DEVICE, STEP_S, AnsweringLine, GuardPipe, WheelBench

VALID_S, WATCHDOG_S = 0.1, 0.2
STAND, CUT, RELEASE = "!M 0 0", "!EX", "!MG"
MISREAD = {b"FF=0": b"FF=x"}


@pytest.fixture
def bench():
    bench = WheelBench()
    bench.motors.open()
    yield bench
    bench.motors.close()


def test_a_driver_without_its_device_row_names_it():
    bench = WheelBench()
    bench.ctx.device = None
    with pytest.raises(DeviceError, match="'motors'"):
        bench.motors.open()


def test_after_opening_it_shows_wheels_at_rest(bench):
    assert (bench.state.left, bench.state.right, bench.state.armed) == (0.0, 0.0, False)
    assert bench.state.motors == {}, "left and right have fields of their own"


def test_wheels_at_rest_are_stepped_less_often_until_they_move_and_until_their_zero_is_acknowledged(bench):
    bench.steps(0.1)
    assert bench.motors.rate_hz == capability.STANDING_HZ
    bench.drive()
    assert bench.motors.rate_hz == capability.RATE_HZ
    bench.line.unheard = (b"!M 0 0\r",)
    bench.steps(0.1, 0.0)
    assert bench.motors.rate_hz == capability.RATE_HZ
    bench.line.unheard = ()
    bench.steps(0.1, 0.0)
    assert bench.motors.rate_hz == capability.STANDING_HZ


# The emergency stop.


def press(bench):
    bench.ctx.estop.engaged, bench.ctx.estop.reason = True, "button"
    bench.step()


def test_an_emergency_stop_cuts_once_and_says_so_when_it_is_acknowledged(bench):
    bench.drive()
    since_s = bench.ctx.now
    press(bench)
    bench.steps(0.5)
    assert bench.written(since_s) == [CUT, STAND]
    assert set(bench.ctx.estop.acknowledged) == {(True, "")}
    assert bench.outputs == (0.0, 0.0)


def test_a_cut_that_is_not_acknowledged_is_repeated_each_tick_and_not_called_done(bench):
    bench.drive()
    bench.line.unheard = (b"!EX\r",)
    since_s = bench.ctx.now
    press(bench)
    bench.step()
    assert [line for line in bench.written(since_s) if line == CUT] == [CUT, CUT]
    assert set(bench.ctx.estop.acknowledged) == {(False, "the controller has not acknowledged")}
    bench.line.unheard = ()
    bench.step()
    assert bench.ctx.estop.acknowledged[-1] == (True, "")


def test_a_cut_that_was_released_elsewhere_is_made_again(bench):
    press(bench)
    bench.line.device.feed(b"!MG\r", bench.ctx.now)
    since_s = bench.ctx.now
    bench.steps(0.3)
    assert bench.written(since_s) == [CUT, STAND]
    assert bench.line.device.cause(bench.ctx.now) == "emergency_stop"


def test_an_emergency_stop_is_no_mishap_and_says_its_reason(bench):
    bench.drive()
    press(bench)
    assert (bench.state.trips, bench.state.reason, bench.state.estop) == (0, "emergency stop: button", True)
    assert bench.ctx.told("trip") == []


def test_a_release_that_the_controller_does_not_acknowledge_holds_the_wheels(bench, wording):
    press(bench)
    bench.ctx.estop.engaged = False
    bench.line.unheard = (b"!MG\r",)
    bench.steps(3 * STEP_S, 0.0)
    assert not bench.state.armed
    wording(bench.state.reason)
    assert bench.ctx.estop.acknowledged[-1] == (True, "")
    bench.line.unheard = ()
    bench.drive()
    assert bench.ctx.estop.acknowledged[-1] == (False, "released")
    assert bench.outputs != (0.0, 0.0)
    assert bench.state.trips == 0


def test_after_a_release_the_next_emergency_stop_cuts_again(bench):
    for _ in range(2):
        since_s = bench.ctx.now
        press(bench)
        assert bench.written(since_s)[0] == CUT
        bench.ctx.estop.engaged = False
        bench.steps(3 * STEP_S)
        assert bench.line.device.cause(bench.ctx.now) != "emergency_stop"


def test_it_cuts_again_also_when_the_controllers_faults_are_not_known_since_the_release(bench):
    press(bench)
    bench.ctx.estop.engaged = False
    bench.line.unheard = (b"?FF\r",)
    bench.step()
    since_s = bench.ctx.now
    press(bench)
    assert bench.written(since_s)[0] == CUT


def test_an_emergency_stop_of_its_own_is_told_as_no_fault(bench):
    press(bench)
    bench.steps(0.5)
    assert bench.state.faults == ("emergency_stop",)
    assert bench.ctx.told("fault") == []
    assert bench.ctx.health == []


def test_one_that_is_not_its_own_stops_is_told_and_says_how_it_ends(bench):
    bench.drive()
    bench.line.device.feed(b"!EX\r", bench.ctx.now)
    bench.steps(0.3, 0.5)
    assert (bench.state.armed, bench.state.trips) == (False, 1)
    assert "not by this robot" in bench.state.reason
    assert "not by this robot" in bench.ctx.told("fault")[0]
    assert bench.ctx.data[bench.ctx.events.index(("fault", bench.ctx.told("fault")[0]))] == {
        "faults": ["emergency_stop"]
    }
    assert "not by this robot" in bench.ctx.health[-1]


def test_a_controller_that_comes_back_is_cut_again_while_the_emergency_stop_lasts(bench):
    press(bench)
    bench.motors.close()
    bench.motors.degraded("unplugged")
    assert bench.ctx.estop.acknowledged[-1] == (False, "unplugged")
    bench.motors.open()
    since_s = bench.ctx.now
    bench.step()
    assert CUT in bench.written(since_s)
    assert bench.ctx.estop.acknowledged[-1] == (True, "")


def test_an_emergency_stop_that_came_and_went_while_the_controller_was_away_is_released_there(bench):
    bench.motors.close()
    bench.ctx.estop.engaged = True
    bench.motors.degraded("unplugged")
    bench.line.device.feed(b"!EX\r", bench.ctx.now)
    bench.ctx.estop.engaged = False
    bench.motors.open()
    bench.steps(2 * STEP_S)
    assert RELEASE in bench.written()
    bench.drive()
    assert bench.outputs != (0.0, 0.0)


# What else forbids motion.


def test_fault_bits_that_are_not_understood_stop(bench, wording):
    bench.drive()
    bench.line.misread = MISREAD
    bench.steps(0.5, 0.5)
    assert (bench.state.armed, bench.state.trips) == (False, 1)
    wording(bench.state.reason)
    assert bench.outputs == (0.0, 0.0)
    bench.line.misread = {}
    bench.steps(0.5, 0.0)
    bench.drive(lease="L2")
    assert bench.outputs != (0.0, 0.0)


def test_a_fault_in_motion_stops_and_is_a_mishap(bench):
    bench.drive()
    bench.line.device.faults = replace(bench.line.device.faults, undervoltage=True)
    bench.steps(0.5, 0.5)
    assert (bench.state.armed, bench.state.trips) == (False, 1)
    assert bench.state.reason == "the controller reports undervoltage"
    assert bench.written()[-1] == STAND


def test_the_controllers_own_emergency_stop_forbids_motion_whatever_else_it_takes_for_grave(bench, monkeypatch):
    monkeypatch.setattr(Controller, "grave", ())
    bench.line.device.feed(b"!EX\r", bench.ctx.now)
    bench.steps(0.5, 0.0)
    assert not bench.state.armed
    assert "not by this robot" in bench.state.reason


def test_the_source_that_was_heard_last_has_to_live(bench):
    bench.ctx.wired["setpoint"] = ("drive", "other")
    bench.drive()
    bench.ctx.gone.add("other")
    bench.steps(STEP_S, 0.5)
    assert bench.state.armed
    bench.ctx.gone = {"drive"}
    bench.step()
    assert (bench.state.armed, bench.state.trips) == (False, 1)
    assert bench.outputs == (0.0, 0.0)
    bench.give(0.0, source="other")
    bench.step()
    bench.give(0.0, source="other")
    bench.step()
    assert bench.state.armed


def test_before_a_source_is_heard_the_first_one_has_to_live(bench):
    bench.ctx.wired["setpoint"] = ("drive", "other")
    bench.ctx.gone.add("drive")
    bench.step()
    assert bench.state.reason == "'drive' is not on the bus"
    assert bench.state.trips == 0


def test_a_setpoint_of_another_than_the_wired_source_neither_arms_nor_moves(bench):
    bench.give(0.0, source="stranger")
    bench.step()
    assert not bench.state.armed
    bench.drive()
    bench.give(0.9, source="stranger")
    bench.step()
    assert bench.state.left == 0.5


def test_without_a_wired_source_nothing_arms(bench):
    bench.ctx.wired["setpoint"] = ()
    bench.steps(2 * STEP_S, 0.0)
    assert not bench.state.armed
    assert bench.state.reason == "no source is wired to the setpoint"
    bench.ctx.wired["setpoint"] = ("drive",)
    bench.drive()
    bench.ctx.wired["setpoint"] = ()
    bench.step()
    assert (bench.state.armed, bench.state.trips) == (False, 0), "its wires were taken, which is no mishap"


def test_a_zero_from_before_the_driver_began_does_not_arm_it():
    bench = WheelBench()
    began, arming = bench.ctx.now, bench.motors._arming
    zeros = [Setpoint((0.0, 0.0), "", born) for born in (began, began + 0.001)]
    assert [receive(arming, zero, began + 1.0, valid_s=10.0).armed for zero in zeros] == [False, True]


def test_after_a_release_nothing_moves_until_a_new_zero(bench):
    bench.drive()
    press(bench)
    bench.ctx.estop.engaged = False
    bench.steps(4 * STEP_S, 0.5)
    assert (bench.outputs, bench.state.armed) == ((0.0, 0.0), False)
    bench.drive(lease="L2")
    assert bench.outputs != (0.0, 0.0)


def test_a_fault_that_the_row_tolerates_is_shown_and_stops_nothing(bench):
    bench.line.misread = {b"FF=0": b"FF=128"}
    bench.steps(0.5)
    assert bench.state.faults == ("default_configuration",)
    bench.drive()
    assert bench.outputs != (0.0, 0.0)


def test_silence_of_the_source_is_a_mishap_that_is_told(bench):
    bench.drive()
    bench.steps(VALID_S + STEP_S)
    assert bench.ctx.told("trip") == ["motors stopped: no setpoint within 0.1 s; waiting for a zero setpoint"]
    assert (bench.state.armed, bench.state.code) == (False, "no_setpoint")
    assert (bench.ctx.levels, bench.ctx.data) == (["warning"], [{"trips": 1}])


@pytest.mark.parametrize(("pause_s", "stops"), [(0.12, False), (0.125, True), (0.35, True)])
def test_a_driver_that_paused_for_as_long_as_a_setpoint_lives_needs_a_new_zero(monkeypatch, pause_s, stops):
    monkeypatch.setattr(Controller, "fed_s_ago", 0.0)  # whatever the controller took meanwhile
    bench = WheelBench('"guard": false, "setpoint_valid_s": 0.125')
    bench.motors.open()
    bench.drive()
    stepped = ceil(bench.ctx.now * 16) / 16
    for at in (stepped, stepped + pause_s):
        bench.began = bench.ctx.now = at
        bench.give(0.5)
        bench.step(0.0)
    assert bench.state.armed is not stops
    assert bench.state.trips == stops
    assert (bench.outputs == (0.0, 0.0)) is stops
    if stops:
        assert f" {pause_s:.2f} s" in bench.state.reason


@pytest.mark.parametrize(("moving_s", "obeyed"), [(0.03, True), (0.09, False)])
def test_a_motion_after_a_rest_is_obeyed_only_if_its_beginning_was_not_long_ago(bench, moving_s, obeyed):
    for power, age_s in ((0.0, 0.0), (0.5, moving_s)):
        setpoint = MotorSetpoint(left=power, right=power, lease="L1", moving_s=age_s)
        bench.ctx.arrive("setpoint", setpoint, source="drive")
        bench.step(0.06)
        assert bench.state.armed is (obeyed or not power)
        bench.steps(0.3 * (not power))


def test_a_driver_that_paused_at_rest_says_so_and_needs_a_new_zero_too(bench):
    bench.steps(2 * STEP_S, 0.0)
    assert bench.state.armed
    bench.ctx.now += 5 * VALID_S
    bench.give(0.0)
    bench.step()
    assert (bench.state.armed, bench.state.trips) == (False, 0)
    assert "the driver was held up" in bench.state.reason
    bench.steps(2 * STEP_S, 0.0)
    assert bench.state.armed


@pytest.mark.parametrize(("fed_s_ago", "stops"), [(0.09, False), (VALID_S, True)])
def test_what_a_ramp_came_to_while_the_controller_took_nothing_needs_a_new_zero(bench, monkeypatch, fed_s_ago, stops):
    bench.steps(2 * STEP_S, 0.0)
    with monkeypatch.context() as late:
        late.setattr(Controller, "fed_s_ago", fed_s_ago)
        bench.steps(STEP_S, 0.0)
        assert bench.state.armed, "at rest nothing was missed"
    bench.steps(2 * STEP_S, 0.5)
    with monkeypatch.context() as late:
        late.setattr(Controller, "fed_s_ago", fed_s_ago)
        bench.steps(STEP_S, 0.5)
    assert (bench.state.armed, bench.state.trips) == (not stops, int(stops))
    assert bench.state.reason == (f"the controller has taken no command for {fed_s_ago:.2f} s" if stops else "")


def test_a_pause_before_it_was_opened_again_counts_for_nothing(bench):
    bench.steps(0.1)
    bench.motors.close()
    bench.ctx.now += 60.0
    bench.ctx.published.clear()
    bench.motors.open()
    bench.steps(0.1)
    assert [state.reason for state in bench.ctx.said("state")] == ["the line was closed", START]


def test_one_that_is_switched_off_holds_the_wheels_and_counts_no_mishap(bench):
    bench.drive()
    off = FakeCall("enable", EnableCommand(enabled=False))
    bench.motors.command(off)
    assert off.answer.accepted
    bench.steps(0.1, 0.5)
    assert bench.outputs == (0.0, 0.0)
    assert (bench.state.reason, bench.state.trips) == ("execution is disabled", 0)


def test_a_row_may_have_it_begin_switched_off():
    bench = WheelBench('"guard": false, "enabled": false')
    bench.motors.open()
    bench.drive()
    assert bench.state.reason == "execution is disabled"
    assert bench.outputs == (0.0, 0.0)


def test_who_switches_it_on_is_answered_once_it_is_armed_or_in_vain_after_a_while(bench):
    calls = [FakeCall("enable", EnableCommand(enabled=True)) for _ in range(3)]
    bench.motors.command(calls[0])
    bench.steps(0.28)
    assert calls[0].answer is None
    bench.steps(2 * STEP_S)
    assert calls[0].answer.accepted
    bench.motors.command(calls[1])
    bench.motors.command(calls[2])
    bench.step()
    assert [call.answer for call in calls[1:]] == [None, None]
    bench.give(0.0)
    bench.step()
    assert [call.answer.accepted for call in calls] == [True, True, True]


@pytest.mark.parametrize("away", [lambda motors: motors.degraded("unplugged"), lambda motors: motors.close()])
def test_who_switches_it_on_is_answered_at_once_when_the_controller_goes_away(bench, away):
    call = FakeCall("enable", EnableCommand(enabled=True))
    bench.motors.command(call)
    away(bench.motors)
    assert call.answer.accepted


def test_another_command_is_refused(bench):
    call = FakeCall("stop", StopCommand())
    bench.motors.command(call)
    assert call.refused


def test_a_controller_that_went_away_is_a_mishap_that_is_told_and_shown(bench):
    bench.drive()
    bench.motors.degraded("unplugged")
    assert bench.ctx.estop.acknowledged == []
    assert (bench.state.trips, bench.state.reason) == (1, "unplugged")
    assert len(bench.ctx.told("trip")) == 1
    bench.motors.close()
    bench.motors.degraded("unplugged")
    assert (bench.state.left, bench.state.right, bench.state.armed) == (0.0, 0.0, False)
    assert bench.state.reason == "unplugged"
    assert bench.state.trips == 1


def test_closing_writes_zero_and_disarms(bench):
    bench.drive()
    since_s = bench.ctx.now
    bench.motors.close()
    assert bench.written(since_s) == [STAND]
    assert bench.line.closed
    bench.motors.open()
    bench.give(0.5, lease="L2")
    bench.step()
    assert bench.outputs == (0.0, 0.0)


# What is written, and how often.


def test_a_setpoint_that_ends_is_followed_by_one_zero(bench):
    bench.drive()
    since_s = bench.ctx.now
    bench.steps(VALID_S + STEP_S)
    assert [line for line in bench.written(since_s) if line == STAND] == [STAND]
    assert bench.outputs == (0.0, 0.0)


def test_a_zero_that_is_not_acknowledged_is_written_again_in_the_next_tick(bench):
    bench.drive()
    bench.line.unheard = (b"!M 0 0\r",)
    bench.ctx.gone.add("drive")
    since_s = bench.ctx.now
    bench.step()
    bench.step()
    assert bench.written(since_s) == [STAND, STAND]
    bench.line.unheard = ()
    bench.steps(3 * STEP_S)
    assert bench.written(since_s) == [STAND, STAND, STAND]
    assert bench.outputs == (0.0, 0.0)


def test_at_rest_the_controller_is_fed_with_zero_twice_in_the_time_of_its_watchdog(bench):
    since_s = bench.ctx.now
    bench.steps(1.0)
    assert set(bench.written(since_s)) == {STAND}
    at = [at for at, data in bench.line.written if at >= since_s and data[:1] == b"!"]
    gaps = [after - before for before, after in pairwise(at)]
    assert all(WATCHDOG_S / 2 <= gap < WATCHDOG_S / 2 + 1.5 * STEP_S for gap in gaps)


def test_a_power_that_goes_on_is_written_each_tick_and_not_more_often(bench):
    bench.drive()
    since_s = bench.ctx.now
    bench.steps(10 * STEP_S, 0.5)
    assert bench.written(since_s) == ["!M 500 500"] * 10
    since_s = bench.ctx.now
    for _ in range(4):
        bench.give(0.5)
        bench.step(0.004)
    assert len(bench.written(since_s)) <= 2
    assert len([at for at, data in bench.line.written if at >= since_s and data[:1] in b"?~"]) <= 2


def test_another_power_is_written_at_once(bench):
    bench.drive()
    bench.give(0.6, 0.4)
    bench.step(0.004)
    assert bench.written()[-1] == "!M 600 400"
    for _ in range(4):
        bench.give(0.6, 0.4)
        bench.step()
    assert (bench.state.left, bench.state.right) == (0.6, 0.4)


def test_it_asks_the_controller_seldom_at_rest_and_each_tick_in_motion(bench):
    def asked(power=None):
        since_s = bench.ctx.now
        bench.steps(1.0, power)
        return [data for at, data in bench.line.written if at >= since_s and data[:1] in b"?~"]

    assert 15 <= len(asked()) <= 26
    bench.drive()
    found = asked(0.5)
    assert len(found) >= 45
    assert set(found) >= {b"?FF\r", b"?A\r", b"?C\r", b"?V\r"}


# What is told.


def test_a_fault_is_told_when_it_comes_and_when_it_goes(bench):
    bench.line.device.faults = replace(bench.line.device.faults, overheat=True)
    bench.steps(0.5, 0.0)
    assert bench.ctx.told("fault") == ["the controller reports overheat"]
    assert bench.ctx.levels == ["error"]
    assert bench.state.reason == "the controller reports overheat"
    assert bench.ctx.health == ["the controller reports overheat"]
    bench.line.device.faults = replace(bench.line.device.faults, overheat=False)
    bench.steps(0.5, 0.0)
    assert bench.ctx.told("fault")[1:] == ["the controller reports no fault any more"]
    assert bench.ctx.levels == ["error", "info"]
    assert bench.ctx.health[-1] == "ready"
    assert bench.state.armed


def test_a_fault_that_lasts_is_told_again_after_it_was_opened_again(bench):
    bench.line.device.faults = replace(bench.line.device.faults, overheat=True)
    for _ in range(2):
        bench.steps(0.5)
        bench.motors.close()
        bench.motors.open()
    bench.step()
    assert len(bench.ctx.told("fault")) == len(bench.ctx.health) == 3


@pytest.mark.parametrize(("power", "least", "most"), [(0.0, 8, 12), (0.5, 15, 20)])
def test_the_state_goes_out_ten_times_a_second_at_rest_and_twenty_in_motion(bench, power, least, most):
    bench.steps(0.2, 0.0)
    bench.steps(0.2, power)
    bench.ctx.published.clear()
    bench.steps(1.0, power)
    assert least <= len(bench.ctx.published) <= most
    assert bench.state.voltage_v == 12.6


def test_the_state_goes_out_at_once_when_it_changes(bench):
    bench.steps(0.2)
    bench.steps(2 * STEP_S, 0.0)
    assert bench.state.armed
    for power in (0.5, 0.0):
        bench.steps(3 * STEP_S, power)
        count = len(bench.ctx.published)
        bench.give(0.5 - power)
        bench.step()
        assert len(bench.ctx.published) > count
        assert bench.state.left == 0.5 - power


def disturb(bench, times, lease="L3", **disturbed):
    """Have so many commands in motion not answered, or refused, each alone."""
    for _ in range(times):
        bench.line.unheard, bench.line.misread = disturbed.get("unheard", ()), disturbed.get("misread", {})
        bench.steps(STEP_S, 0.5, lease)
        bench.line.unheard, bench.line.misread = (), {}
        bench.steps(4 * STEP_S, 0.5, lease)


LOST = {"unheard": (b"!M 500 500\r",)}


def test_commands_unanswered_are_told_when_they_are_eight_and_whenever_they_have_doubled_but_seldom(bench):
    bench.ctx.now = bench.began = 1000.0
    bench.steps(0.5, 0.0)
    bench.drive(lease="L2")
    disturb(bench, 7, **LOST)
    assert bench.ctx.told("unanswered") == []
    disturb(bench, 1, **LOST)
    assert bench.ctx.data[-1] == {"lost": 8, "refused": 0}
    disturb(bench, 7, **LOST)
    bench.steps(5.0, 0.5)
    assert len(bench.ctx.told("unanswered")) == 1
    disturb(bench, 1, **LOST)
    assert bench.ctx.data[-1] == {"lost": 16, "refused": 0}
    disturb(bench, 16, **LOST)
    assert len(bench.ctx.told("unanswered")) == 2
    bench.steps(5.0, 0.5)
    assert bench.ctx.data[-1] == {"lost": 32, "refused": 0}
    assert set(bench.ctx.levels) == {"warning"}


def test_those_that_are_refused_count_too_and_all_anew_after_it_was_opened_again(bench):
    bench.drive()
    disturb(bench, 4, **LOST)
    disturb(bench, 4, misread={b"+\r": b"-\r"})
    assert bench.ctx.data[-1] == {"lost": 4, "refused": 4}
    bench.motors.close()
    bench.motors.open()
    bench.steps(5.0, 0.0)
    bench.drive(lease="L4")
    disturb(bench, 8, "L4", **LOST)
    assert bench.ctx.data[-1] == {"lost": 8, "refused": 0}


# Other motors than left and right.

PLACES = zip(FOUR, (0.1, 0.1, -0.1, -0.1), (0.1, -0.1, 0.1, -0.1), strict=True)
SKID = (
    Kinematics(name="base", kind="skid"),
    *(Wheel(name=name, motor=name, x_m=x_m, y_m=y_m, diameter_m=0.1) for name, x_m, y_m in PLACES),
)


class QuadBench:
    """Four motors on a line in memory, with the rows of a base."""

    def __init__(self, rows=(), counts="0 1 2 3"):
        self.ctx = FakeContext(QUAD, QUAD.parse('{"device": "motors", "guard": false}'), device=DEVICE, given=rows)
        self.ctx.wired["setpoint"] = ("drive",)
        self.line = AnsweringLine(f"C {counts} ok\r".encode())
        self.motors = Quad(self.ctx)
        self.motors.connect = lambda *_: TinyController(self.line, self.ctx.clock, lambda: None, STOP_FOUR)
        self.motors.open()

    def give(self, *powers):
        setpoint = MotorSetpoint(left=0.0, right=0.0, lease="L1", motors=dict(zip(FOUR, powers, strict=False)))
        self.ctx.arrive("setpoint", setpoint, source="drive")
        self.motors.step()
        self.ctx.now += STEP_S
        return self.ctx.said("state")[-1]


@pytest.mark.parametrize(("rows", "sides"), [(SKID, (0.3, 0.5)), ((), (0.0, 0.0)), (SKID[:2], None)])
def test_it_tells_of_each_motor_and_what_they_are_for_the_sides_of_its_base(rows, sides):
    if sides is None:
        rows = (SKID[0], *(replace(row, motor=f"other_{row.motor}") for row in SKID[1:]))
        sides = (0.0, 0.0)
    bench = QuadBench(rows)
    bench.give()
    bench.give(0.0, 0.0, 0.0, 0.0)
    bench.give(0.3, 0.5, 0.3, 0.5)
    bench.ctx.now += 0.05
    state = bench.give(0.3, 0.5, 0.3, 0.5)
    assert (state.left, state.right) == pytest.approx(sides)
    assert {name: (motor.power, motor.counts) for name, motor in state.motors.items()} == {
        name: (power, count) for count, (name, power) in enumerate(zip(FOUR, (0.3, 0.5, 0.3, 0.5), strict=True))
    }
    assert bench.line.written[-1] == b"P 300 500 300 500\r"


def test_a_zero_for_left_and_right_is_one_for_all_motors_and_a_power_is_none():
    bench = QuadBench()
    for power, armed in ((0.0, True), (0.2, False)):
        bench.ctx.now += STEP_S
        bench.ctx.arrive("setpoint", MotorSetpoint(left=power, right=power, lease="L1"), source="drive")
        bench.motors.step()
        assert bench.ctx.said("state")[-1].armed is armed
    assert "'front_left'" in bench.ctx.said("state")[-1].reason


@pytest.mark.parametrize(("powers", "missing"), [((0.1, 0.1, 0.1), "rear_right"), ((), "front_left")])
def test_a_setpoint_that_does_not_name_every_motor_stops_all(powers, missing):
    bench = QuadBench()
    for each in (0.0, 0.0, 0.5):
        bench.give(*[each] * 4)
    assert bench.line.written[-1] == b"P 500 500 500 500\r"
    setpoint = MotorSetpoint(left=0.1, right=0.1, lease="L1", motors=dict(zip(FOUR, powers, strict=False)))
    bench.ctx.arrive("setpoint", setpoint, source="drive")
    bench.motors.step()
    assert bench.line.written[-1] == STOP_FOUR
    assert f"gives motor '{missing}' no power" in bench.ctx.said("state")[-1].reason
    bench.ctx.now += STEP_S
    bench.give(0.5, 0.5, 0.5, 0.5)
    assert bench.line.written[-1] == STOP_FOUR


def test_a_controller_that_measures_of_fewer_motors_than_it_drives_is_a_drivers_defect():
    with pytest.raises(ValueError, match="shorter"):
        QuadBench(counts="0 1 2")


# Its guard.


@pytest.fixture
def guarded(monkeypatch):
    monkeypatch.setattr(capability, "Guard", GuardPipe)
    bench = WheelBench('"guard_silence_ms": 150')
    bench.motors.open()
    bench.guard = GuardPipe.newest
    yield bench
    bench.motors.close()


def test_a_guard_knows_the_line_the_stop_and_its_drivers_time_of_silence(guarded):
    line, stop, silence_ms = guarded.guard.told
    assert (line, stop.request, stop.acknowledged, silence_ms) == (guarded.line.fileno(), b"!M 0 0\r", b"+\r", 150)


def test_its_guard_hears_of_a_power_before_the_controller_does_and_of_the_rest_after_it(guarded):
    guarded.step()
    assert guarded.guard.beats[-1] is False
    guarded.drive()
    turned = next(at for at, data in guarded.line.written if data == b"!M 500 500\r")
    assert guarded.guard.first_turning_at <= turned
    guarded.ctx.gone.add("drive")
    guarded.steps(2 * STEP_S)
    assert guarded.guard.beats[-1] is False


def test_its_guard_hears_each_step_that_goes_by(guarded):
    for _ in range(3):
        count = len(guarded.guard.beats)
        guarded.step(0.001)
        assert len(guarded.guard.beats) > count


def test_nothing_moves_before_its_guard_listens_and_that_is_no_mishap(guarded):
    guarded.guard.listens = False
    guarded.drive()
    assert guarded.outputs == (0.0, 0.0)
    assert (guarded.state.reason, guarded.state.trips) == (GUARD_STARTS, 0)
    assert guarded.ctx.health == [GUARD_STARTS]
    guarded.guard.listens = True
    guarded.drive()
    assert guarded.outputs != (0.0, 0.0)
    assert guarded.ctx.health[-1] == "ready"


def test_without_a_guard_that_stands_it_opens_again(guarded):
    guarded.guard.standing = False
    with pytest.raises(DeviceError, match="'motors': its guard process"):
        guarded.step()


def test_a_guard_that_was_frozen_is_told_once(guarded):
    guarded.guard.was_frozen = True
    guarded.step()
    guarded.step()
    assert len(guarded.ctx.told("guard")) == 1
    assert guarded.ctx.levels == ["warning"]


@pytest.mark.parametrize(("unheard", "last"), [((), "dismissed"), ((b"!M 0 0\r",), "spoke")])
def test_a_guard_is_dismissed_only_if_the_last_zero_was_acknowledged(guarded, unheard, last):
    guarded.drive()
    guarded.line.unheard = unheard
    guarded.motors.close()
    assert guarded.guard.last == [last]
    guarded.motors.close()
    assert guarded.guard.last == [last]


def test_a_guard_speaks_where_closing_itself_fails(guarded, monkeypatch):
    def fails():
        raise RuntimeError("a driver's own defect")

    guarded.drive()
    monkeypatch.setattr(guarded.line, "drop_output", fails)
    with pytest.raises(RuntimeError):
        guarded.motors.close()
    assert guarded.guard.last == ["spoke"]


def test_a_guard_that_cannot_be_started_is_a_device_error(monkeypatch):
    def full(*_):
        raise OSError("no memory")

    monkeypatch.setattr(capability, "Guard", full)
    bench = WheelBench('"guard": true')
    with pytest.raises(DeviceError, match=r"'motors'.*no memory"):
        bench.motors.open()
