"""What is published of one servo and of its line: what was read, as long as it is young, and what was ordered."""

from types import SimpleNamespace

import pytest

from lbr.drivers.servos.contract import Counts, Seen, SlowState, Snapshot
from lbr.drivers.servos.targets import TargetState
from lbr.drivers.servos.view import servo_state, statistics
from lbr.messages.servos import BusStatistics, ServoState

NOW = 100.0
MODEL = SimpleNamespace(full_torque=1000, position_rad=lambda raw: raw / 100.0, faults=lambda error: (f"bit {error}",))
MOTION = SimpleNamespace(
    error=4, position=512, speed=7, position_rad=1.2345678, speed_rps=0.123456, load_fraction=-0.43219
)


def slow(age_s=0.5, *, enabled=True, limit=500):
    return SlowState(NOW - age_s, enabled, 520, 100, limit, 11.9, 41.0)


def shown(target=None, **seen):
    servo = target or TargetState(3, known=True, on=True, goal=520, limit=700, settled=NOW - 0.2)
    return servo_state(
        servo, Seen(**{"motion": MOTION, "at": NOW - 0.1, "slow": slow(), "error": 2} | seen), MODEL, NOW
    )


def test_a_servo_is_shown_as_it_was_read_with_the_torque_of_its_last_order():
    assert shown() == ServoState(
        id=3,
        position_rad=1.23457,
        speed_rps=0.1235,
        load=-0.4322,
        goal_rad=5.2,
        torque=0.7,
        voltage_v=11.9,
        temperature_c=41.0,
        faults=("bit 2",),
        raw=512,
        age_s=0.1,
    )


def test_what_is_old_is_not_shown():
    found = shown(at=NOW - 0.26, slow=slow(5.1))
    assert (found.position_rad, found.speed_rps, found.load, found.raw, found.faults) == (None, None, None, None, ())
    assert (found.voltage_v, found.temperature_c, found.age_s) == (None, None, 0.26)
    assert shown(at=NOW - 0.24, slow=slow(4.9)).voltage_v == 11.9
    assert ServoState(id=3) == servo_state(TargetState(3), Seen(), MODEL, NOW)


@pytest.mark.parametrize(
    ("target", "read", "torque"),
    [
        ({"known": True, "on": True, "limit": 700, "settled": NOW - 0.2}, slow(0.1, limit=300), 0.3),
        ({"known": True, "on": True, "limit": 700, "settled": NOW - 0.2}, slow(0.3, enabled=False), 0.7),
        ({"known": True, "on": True, "limit": 700}, None, 0.7),
        ({"known": True, "on": False, "limit": 700, "settled": NOW}, slow(), 0.0),
        ({}, slow(limit=300), 0.3),
        ({}, slow(enabled=False), 0.0),
        ({}, None, None),
    ],
)
def test_torque_is_that_of_the_last_order_or_of_a_later_reading(target, read, torque):
    assert shown(TargetState(3, **target), slow=read).torque == torque


def test_a_goal_without_torque_is_none_and_the_first_thing_that_is_wrong_is_the_reason():
    target = TargetState(3, known=True, goal=520, latched=("hot",), trouble="is hot", blocked="was released")
    found = shown(target)
    assert (found.goal_rad, found.latched, found.reason) == (None, ("hot",), "is hot")
    assert shown(target, reason="does not answer").reason == "does not answer"
    target.trouble = ""
    assert shown(target).reason == "was released"


def test_the_statistics_are_those_of_the_last_sweeps_and_of_the_line():
    counts = Counts(timeouts=1, corrupt=2, retries=3, strays=4, babble=5)
    snapshot = Snapshot(7, NOW, {}, sweeps_hz=99.96, states_hz=180.04, sweep_s=0.0091234, together=True)
    assert statistics(SimpleNamespace(counts=counts), snapshot) == BusStatistics(
        sweeps_hz=100.0, states_hz=180.0, sweep_ms=9.12, timeouts=1, corrupt=2, retries=3, strays=4, sync_read=True
    )
