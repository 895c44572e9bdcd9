"""A driver of servos passes what `lbr.testing.servos` checks on motors that turn, and one that is wrong in one thing does not."""

import pytest

from lbr.capability.registry import find
from lbr.drivers.dynamixel import bus as wire
from lbr.drivers.dynamixel import table
from lbr.drivers.servos.targets import ServoTargets
from lbr.testing import servos
from lbr.testing.servos import CHECKS, bench

IDS = (1, 2, 3)
PATIENT = {"reply_margin_s": 0.05}


@pytest.fixture
def bioloid(tmp_path):
    with bench(find("dynamixel", tmp_path), tmp_path, ids=IDS, settings=PATIENT) as found:
        yield found


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_our_driver_of_servos_does_what_every_one_has_to(check, bioloid):
    check(bioloid)


def jerks(self, servo, speed, limit):
    """Leave a servo the goal of before."""
    self.put(servo, table.TORQUE_ENABLE, 1)
    self.put(servo, table.GOAL_POSITION, 512)
    return 512


def keeps(self, servos):
    """Take no torque off."""


def deaf(self, goals):
    """Write no goals."""


def goes_on(self, outs, snapshot):
    """Hold none."""


def never(self, snapshot, *, released):
    """Say that all have stopped, unseen."""
    return []


@pytest.mark.parametrize(
    ("where", "name", "wrong", "check", "said"),
    [
        (wire.Bus, "torque_on", jerks, servos.switches_torque_on_where_the_servos_are, "write where it is as its goal"),
        (wire.Bus, "write_goals", deaf, servos.follows_its_goals, "all have turned by 0.5 rad"),
        (ServoTargets, "_freeze", goes_on, servos.stays_where_it_is_stopped, "went on by"),
        (wire.Bus, "torque_off", keeps, servos.lets_go_of_what_nobody_moves, "all are without torque"),
        (wire.Bus, "write_limits", deaf, servos.lets_go_of_what_nobody_moves, "torque went at once"),
        (ServoTargets, "unconfirmed", never, servos.holds_in_an_emergency_stop, "went on by"),
    ],
    ids=["jerks", "deaf", "goes_on", "keeps", "drops", "acknowledges_unseen"],
)
def test_a_driver_that_does_one_thing_wrong_is_found_out(where, name, wrong, check, said, bioloid, monkeypatch):
    monkeypatch.setattr(where, name, wrong)
    monkeypatch.setattr("lbr.testing.driver.WITHIN_S", 4.0)
    if wrong is never:
        monkeypatch.setattr(wire.Bus, "write_positions", deaf)
    with pytest.raises(AssertionError, match=said):
        check(bioloid)


def test_a_driver_without_a_guard_is_found_out(bioloid, monkeypatch):
    monkeypatch.setattr("lbr.testing.servos.GUARD_S", 2.0)
    monkeypatch.setattr(bioloid, "row", {**bioloid.row, "hold_s": 60.0})
    with pytest.raises(AssertionError, match="no guard acted"):
        servos.is_outlived_by_its_guard(bioloid)
