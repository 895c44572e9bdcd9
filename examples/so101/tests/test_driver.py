"""The driver against the emulated bus on a pty: motion, holding, and reports."""

import pytest
from conftest import IDS, Arm
from lbr_so101.table import RAD_PER_STEP

from lbr.messages.servos import RecoverServos
from lbr.testing import FakeCall
from lbr.testing.device import plugged
from lbr.testing.driver import CHECKS, DriverBench

PLACES = {str(number): 0.1 * number for number in IDS}


@pytest.mark.parametrize("check", CHECKS)
def test_it_does_what_every_driver_has_to(check, arm):
    check(arm)
    assert isinstance(arm, DriverBench)


@pytest.mark.parametrize("device", [{"positions_rad": PLACES}], indirect=True)
def test_opening_moves_nothing_and_torque_comes_on_where_the_servos_are(arm):
    arm.until(lambda: arm.each(lambda servo: servo.voltage_v == 12.0), "six servos")
    assert arm.state.phase == "released"
    assert not any(arm.torques())
    assert arm.state.bus.sync_read
    arm.on()
    arm.steps(0.2)
    for number, servo in arm.servos.items():
        assert abs(servo.felt.position_rad - PLACES[str(number)]) <= RAD_PER_STEP


def test_goals_are_followed_and_a_silent_sender_ends_in_hold_fade_and_off(arm):
    arm.on(position_rad=-0.5, speed_rps=3.0)
    arm.until(lambda: arm.each(lambda one: abs((one.position_rad or 0.0) + 0.5) < 0.01), "the goal")
    arm.goals = None
    arm.until(lambda: arm.state.phase == "holding", "hold")
    arm.until(lambda: any(servo.word(48) < 700 for servo in arm.servos.values()), "fading")
    arm.until(lambda: arm.state.phase == "released" and not any(arm.torques()), "off")


def test_a_stop_holds_every_servo_where_it_is_and_is_read_back(arm):
    arm.on(position_rad=1.5, speed_rps=1.0)
    arm.ctx.estop.engaged = True
    arm.until(lambda: any(stopped for stopped, _ in arm.ctx.estop.acknowledged), "acknowledged")
    assert all(arm.torques())
    places = [servo.felt.position_rad for servo in arm.servos.values()]
    assert max(places) < 1.4
    arm.steps(0.3)
    assert [servo.felt.position_rad for servo in arm.servos.values()] == pytest.approx(places, abs=0.02)


def test_an_overload_is_named_takes_that_servos_torque_and_is_recovered(arm):
    arm.on(position_rad=0.3)
    arm.device.fault("overload", (3,))
    arm.until(lambda: arm.torques() == [number != 3 for number in IDS], "servo 3 without torque")
    arm.until(lambda: arm.seen(3).latched == ("overload",), "named")
    assert arm.seen(3).position_rad is not None
    assert arm.each(lambda servo: servo.id == 3 or not servo.latched)
    call = FakeCall("recover", RecoverServos())
    arm.driver.command(call)
    arm.until(lambda: call.answer is not None, "recovered")
    assert not call.refused
    assert "recovered, without torque: elbow_flex" in call.answer.reason


@pytest.mark.parametrize("device", [{"registers": {"35": 40, "36": 50}}], indirect=True)
def test_a_blocked_joint_ends_in_an_overload_of_its_own(arm):
    arm.device.fault("blocked", (2,))
    arm.on(position_rad=0.8)
    arm.until(lambda: arm.seen(2).latched == ("overload",), "overload")
    assert arm.seen(1).latched == ()


def test_heat_latches_and_is_not_recovered_before_it_is_over(arm):
    arm.on(position_rad=0.2)
    arm.device.fault("hot", (5,))
    arm.until(lambda: arm.seen(5).latched == ("overheat",), "latched")
    call = FakeCall("recover", RecoverServos(ids=(5,)))
    arm.driver.command(call)
    arm.until(lambda: call.answer is not None, "answered")
    assert "too hot" in call.refused


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("silent", "does not answer"),
        ("unpowered", "does not answer"),
        ("wrong_model", "is a model 1284"),
        ("duplicate", "two servos with id 4"),
        ("other_baud", "does not answer"),
    ],
)
def test_a_bad_servo_is_named_and_the_others_go_on(fault, said, arm):
    arm.device.fault(fault, (4,))
    arm.send(position_rad=0.3)
    others = [number for number in IDS if number != 4]
    arm.until(lambda: all(arm.servos[number].torque for number in others), "the others")
    arm.until(lambda: said in arm.reason(4), said)
    assert not any(arm.seen(number).reason for number in others)
    assert not arm.servos[4].torque


@pytest.mark.parametrize(
    ("registers", "said"),
    [
        ({"33": 1}, "mode 1"),
        ({"9": 0, "11": 0}, "endlessly"),
        ({"18": 28}, "register 18 is 28"),
        ({"18": 8}, "register 18 is 8"),
        ({"8": 0}, "response level"),
        ({"9": 2500, "11": 3000}, "outside its own limits (2500 to 3000)"),
    ],
)
def test_a_servo_set_up_in_another_way_is_refused_in_words_and_never_moves(registers, said, tmp_path):
    with plugged("feetech", tmp_path, name="arm", settings={"registers": registers}) as device:
        arm = Arm(device)
        arm.send(position_rad=0.3)
        arm.until(lambda: arm.each(lambda servo: said in servo.reason), said)
        assert not any(arm.torques())
        assert all(servo.felt.position_rad == 0.0 for servo in arm.servos.values())
        arm.close()


def test_servos_that_were_without_power_stay_limp_though_goals_go_on_and_a_goal_switches_them_on(arm):
    arm.on(position_rad=0.4)
    arm.until(lambda: arm.each(lambda one: abs((one.position_rad or 0.0) - 0.4) < 0.01), "the goal")
    arm.device.fault("unpowered", (2, 3))
    arm.until(lambda: all("does not answer" in arm.seen(number).reason for number in (2, 3)), "no power")
    arm.send(position_rad=-0.4)
    arm.steps(0.2)
    arm.device.fault("unpowered", ())
    arm.until(lambda: all("lost its torque" in arm.seen(number).reason for number in (2, 3)), "told")
    arm.steps(0.3)
    assert arm.torques() == [number not in {2, 3} for number in IDS]
    assert all(abs(arm.servos[number].felt.position_rad - 0.4) < 0.01 for number in (2, 3))


@pytest.mark.parametrize(
    "faults",
    [
        {"drop": 0.05}, {"bit_flip": 0.05}, {"garbage": 0.1}, {"half": 0.05}, {"late": 0.03}, {"echo": True},
        {"babbling": True},
    ],
    ids=lambda faults: next(iter(faults)),
)  # fmt: skip
def test_on_a_bad_line_every_position_is_true(faults, tmp_path):
    with plugged("feetech", tmp_path, name="arm", settings={"positions_rad": PLACES, "faults": faults}) as device:
        arm = Arm(device)
        arm.until(
            lambda: arm.state is not None and sum(one.position_rad is not None for one in arm.state.servos) > 3, "most"
        )
        arm.steps(1.0)
        states = arm.ctx.said("state")
        seen = [(one.id, one.position_rad) for state in states for one in state.servos if one.position_rad is not None]
        assert len(seen) > 50
        assert all(at == pytest.approx(PLACES[str(number)], abs=RAD_PER_STEP) for number, at in seen)
        assert not any(arm.torques())
        arm.close()


@pytest.mark.parametrize("device", [{"absent_ends_answers": True, "faults": {"unpowered": [3]}}], indirect=True)
def test_servos_behind_an_absent_one_are_read_though_it_ends_the_answers(arm):
    arm.until(lambda: all(arm.seen(n) and arm.seen(n).position_rad is not None for n in IDS if n != 3), "five")
    arm.steps(0.5)
    assert arm.seen(3).position_rad is None
    assert arm.each(lambda servo: servo.id == 3 or not servo.reason)


def test_a_cable_that_breaks_silences_those_behind_it_alone(arm):
    arm.on(position_rad=0.2)
    arm.device.fault("cut_behind", (4,))
    arm.until(lambda: all("does not answer" in arm.seen(number).reason for number in (5, 6)), "5 and 6")
    assert not any(arm.seen(number).reason for number in (1, 2, 3, 4))
    assert all(arm.servos[number].torque for number in (1, 2, 3, 4))


def test_nothing_that_servos_keep_is_ever_written(arm):
    arm.on(position_rad=0.2)
    arm.steps(0.3)
    writes = [parameters[0] for _, code, parameters in arm.twin.log if code in {3, 0x83}]
    assert writes
    assert min(writes) >= 40
