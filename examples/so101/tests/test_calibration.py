"""Calibration by itself: the rows from a hand's movements, and when no row is written."""

from math import nan

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lbr_so101.calibration import KIND, CalibrationSettings, DoneCommand, ZeroCommand
from lbr_so101.calibration.sweep import begin, learnt, moved

from lbr.errors import InputError
from lbr.messages.joints import Joint, MotionStep
from lbr.messages.leases import StopCommand
from lbr.messages.servos import ServosState, ServoState
from lbr.testing import FakeCall, FakeContext

SETTINGS = CalibrationSettings()
PAN = Joint(name="pan", device_id=1, lower_rad=-1.0, upper_rad=1.0, speed_rps=2.0)
ROLL = Joint(name="roll", device_id=2, lower_rad=-2.0, upper_rad=2.0, speed_rps=2.0, sign=-1)
Angles = st.floats(-3.0, 3.0)


def after(zero, *places, joint=PAN):
    sweep = begin({joint.device_id: zero})
    for at in places:
        sweep = moved(sweep, {joint.device_id: at}, SETTINGS.enough_rad)
    (row,) = learnt((joint,), sweep, SETTINGS)
    return row


def test_zero_sign_and_limits_are_where_the_hand_was():
    up = after(0.4, 0.6, 1.4, 0.4, -0.8)
    assert (up.zero_rad, up.sign) == (0.4, 1)
    assert (up.lower_rad, up.upper_rad) == pytest.approx((-1.17, 0.97))
    down = after(0.4, 0.2, -0.8, 0.4, 1.4)
    assert (down.zero_rad, down.sign) == (0.4, -1)
    assert (down.lower_rad, down.upper_rad) == pytest.approx((-0.97, 1.17))


def test_a_joint_that_hardly_moved_gets_its_zero_alone():
    row = after(0.5, 0.6, 0.4, joint=ROLL)
    assert (row.zero_rad, row.sign, row.lower_rad, row.upper_rad) == (0.5, -1, -2.0, 2.0)


def test_a_servo_that_goes_over_the_seam_of_its_turn_is_named():
    with pytest.raises(InputError, match=r"servo 1 went over the seam of its turn, from 3\.00 to -3\.00"):
        after(2.0, 3.0, -3.0)


@given(Angles, st.lists(Angles, max_size=20))
def test_whatever_the_hand_does_limits_are_in_order_and_the_places_within_the_ends(zero, places):
    try:
        row = after(zero, *places)
    except InputError:
        return
    assert row.lower_rad < row.upper_rad
    assert row.name == PAN.name
    if row.lower_rad != PAN.lower_rad:
        seen = [row.sign * (at - row.zero_rad) for at in (zero, *places)]
        assert row.lower_rad >= min(seen)
        assert row.upper_rad <= max(seen)


class Bench:
    def __init__(self, *given):
        self.ctx = FakeContext(KIND, SETTINGS, given=(PAN, ROLL, *given))
        self.run = KIND.load()(self.ctx)
        self.run.open()
        self.show()

    def show(self, pan=0.0, roll=0.0, torque=0.0):
        servos = tuple(ServoState(id=number, position_rad=at, torque=torque) for number, at in ((1, pan), (2, roll)))
        self.ctx.now += 0.02
        state = ServosState(sweep=1, measured_s=0.0, armed=True, phase="released", servos=servos)
        self.ctx.arrive("servos", state, source="arm")
        self.run.step()

    def say(self, name, message):
        call = FakeCall(name, message)
        self.run.command(call)
        return call

    def zero(self):
        return self.say("zero", ZeroCommand())

    def done(self):
        return self.say("done", DoneCommand())


def test_rows_are_learnt_when_all_is_done():
    bench = Bench()
    assert "/calibrate/done" in bench.zero().answer.reason
    for at in (0.5, 1.5, 0.0, -1.5):
        bench.show(pan=at)
    assert bench.ctx.said("state")[-1].running
    answer = bench.done().answer
    assert answer.accepted
    assert "only 0 of roll, which hardly moved" in answer.reason
    (rows,) = bench.ctx.kept
    assert [(row.name, row.upper_rad) for row in rows] == [("pan", 1.47), ("roll", 2.0)]
    assert "nothing is being calibrated" in bench.done().refused


def test_nothing_begins_with_torque_or_without_a_reading():
    bench = Bench()
    bench.show(torque=1.0)
    assert "pan has torque" in bench.zero().refused
    for pan in (None, nan):
        bench.show(pan=pan)
        assert "pan (servo 1) is not measured" in bench.zero().refused
    bench.show()
    bench.ctx.now += 1.0
    assert bench.zero().answer.code == "stale_sensor"


@pytest.mark.parametrize("what", ["torque", "stop", "seam"])
def test_what_is_given_up_changes_nothing(what):
    bench = Bench()
    bench.zero()
    if what == "torque":
        bench.show(torque=1.0)
    elif what == "seam":
        bench.show(pan=3.0)
        bench.show(pan=-3.0)
    else:
        bench.say("stop", StopCommand())
    assert bench.ctx.told("calibration_ended")
    assert "the rows are as they were" in bench.done().refused
    assert not bench.ctx.kept


def test_ends_that_a_motion_goes_beyond_are_not_written():
    bench = Bench(MotionStep(motion="reach", step=1, duration_s=1.0, positions={"pan": 0.9}))
    bench.zero()
    bench.show(pan=0.5)
    bench.show(pan=-0.8)
    assert "key frame 1 of 'reach' has pan at 52 degrees" in bench.done().refused
    assert not bench.ctx.kept
    bench.show(pan=1.2)
    assert bench.done().answer.accepted
