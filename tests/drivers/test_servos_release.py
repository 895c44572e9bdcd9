"""What a guard tells servos whose registers can be read: held where they are, faded from their own limit, let go."""

from types import SimpleNamespace

import pytest

from lbr.drivers.servos.contract import SlowState
from lbr.drivers.servos.register_release import RegisterRelease

MODEL = SimpleNamespace(
    holding_goal=lambda position, speed, goal: goal if abs(position - goal) < 5 + speed else position
)


class Bus:
    """A bus of servos, each with its position, goal and torque limit; None: it does not answer."""

    def __init__(self, **servos):
        self.servos = {int(name.removeprefix("servo")): servo for name, servo in servos.items()}
        self.told, self.asked = [], []

    def drain(self):
        self.told.append("drain")

    def read_state(self, servo, _patience_s):
        self.asked.append(servo)
        if self.servos[servo] is None:
            return None
        position, goal, limit = self.servos[servo]
        motion = None if position is None else SimpleNamespace(position=position, speed=0)
        return motion, SlowState(0.0, bool(limit), goal, 100, limit, 12.0, 30.0)

    def write_positions(self, goals):
        self.told.append(goals)

    def write_limits(self, limits):
        self.told.append(limits)

    def torque_off(self, servos):
        self.told.append(list(servos))


def release(bus):
    return RegisterRelease(bus, MODEL, list(bus.servos))


def test_each_servo_with_torque_is_held_where_it_is_and_fades_from_its_own_limit():
    bus = Bus(servo1=(512, 600, 1000), servo2=(512, 514, 300), servo3=(512, 512, 0))
    guard = release(bus)
    assert guard.hold()
    assert bus.told == ["drain", {1: 512, 2: 514}], "near its goal it keeps that, or it would sag"
    bus.told.clear()
    guard.fade(0.5)
    guard.fade(0.0)
    guard.off()
    assert bus.told == [{1: 500, 2: 150}, {1: 1, 2: 1}, [1, 2, 3]]
    assert (guard.prepare(), guard.blind, guard.least_hold_s) == (0.0, False, 0.0)


@pytest.mark.parametrize(("servo", "held"), [((512, 512, 0), False), ((512, 600, 9), True), (None, True)])
def test_it_holds_while_a_servo_has_torque_or_may_have_it(servo, held):
    assert release(Bus(servo1=servo)).hold() is held


def test_servos_that_did_not_answer_are_asked_again_one_at_a_time():
    bus = Bus(servo1=None, servo2=None, servo3=(512, 512, 0))
    guard = release(bus)
    guard.hold()
    bus.asked.clear()
    guard.keep()
    guard.keep()
    bus.servos[1] = (700, 600, 1000)
    guard.keep()
    assert bus.asked == [1, 2, 1]
    assert bus.told[-1] == {1: 700}


def test_a_servo_whose_motion_is_not_known_keeps_its_goal_and_fades():
    bus = Bus(servo1=(None, 600, 1000))
    guard = release(bus)
    assert guard.hold()
    guard.fade(0.5)
    assert bus.told == ["drain", {}, {1: 500}]
