"""A table that begins by itself when the battery is low: once, and only while the robot is left alone."""

import pytest

from lbr.apps.behaviours.low_battery import ALONE_FOR_S, LOW_FOR_S, LowBattery
from lbr.messages.battery import BatteryState
from lbr.messages.leases import StopCommand
from tests.apps.behaviours.test_behaviour_capability import Stage
from tests.support.replies import drive_state

WELL = {"low": False, "charging": False, "busy": False}
LOW = {**WELL, "low": True}


def begins(watch: LowBattery, now: float, seconds: float, **seen) -> list[float]:
    """Return when it begins, counted from `now`."""
    rounds = [now + 0.5 * number for number in range(int(seconds * 2))]
    return [at - now for at in rounds if watch.due(at, **seen)]


def test_it_begins_once_after_a_while_and_again_when_the_battery_was_well_between():
    low = LowBattery()
    assert begins(low, 0.0, 60.0, **WELL) == []
    assert begins(low, 60.0, 300.0, **LOW) == [LOW_FOR_S]
    assert begins(low, 400.0, 5.0, **WELL) == []
    assert begins(low, 405.0, 60.0, **LOW) == [LOW_FOR_S]


@pytest.mark.parametrize("seen", [{"charging": True}, {"busy": True}, {"low": None}])
def test_it_does_not_begin_while(seen):
    assert begins(LowBattery(), 0.0, 100.0, **{**LOW, **seen}) == []


def test_it_waits_until_the_robot_has_been_left_alone_for_a_while():
    low = LowBattery()
    begins(low, 0.0, 60.0, **{**LOW, "busy": True})
    assert begins(low, 60.0, 60.0, **LOW) == [ALONE_FOR_S]


def hear(stage, seconds, level="low", **drive):
    for _ in range(int(seconds)):
        stage.ctx.arrive("battery", BatteryState(valid=True, level=level, charging=False))
        stage.ctx.arrive("drive", drive_state(**drive))
        stage.play(0.9)


def test_a_row_says_so_and_the_table_begins_by_itself():
    stage = Stage(when_low="patrol")
    hear(stage, 8)
    assert stage.state.phase == "resting"
    hear(stage, 8)
    assert (stage.state.phase, stage.state.table) == ("running", "patrol")
    stage.say("stop", StopCommand())
    hear(stage, 30)
    assert stage.state.phase == "ended", "who stopped it has the last word"


def test_without_such_a_row_nothing_begins_and_nothing_while_another_moves_the_robot():
    stage, driven = Stage(), Stage(when_low="patrol")
    hear(stage, 20)
    hear(driven, 20, holder="page")
    assert stage.state.phase == driven.state.phase == "resting"


def test_a_table_that_is_not_there_is_told_once():
    stage = Stage(when_low="dock")
    hear(stage, 30)
    assert len(stage.ctx.told("behaviour_refused")) == 1
