import threading
from itertools import pairwise

import pytest

from lbr.console.ear import Ear
from lbr.console.lease_keeper import LeaseKeeper, describe
from lbr.messages.drive import GoalResult
from tests.support.waiting import HANG_S, until


@pytest.fixture
def ended():
    return []


@pytest.fixture
def hold(client, ended):
    holders = []
    hearing = Ear(clock=lambda: 0.0)

    def start(what, ear=hearing):
        holder = LeaseKeeper(client, what, "console@here", ear, on_end=ended.append)
        holders.append(holder)
        holder.start()
        return holder

    yield start
    for holder in holders:
        holder.drop()
        holder.join()


def test_a_hold_is_renewed_ten_times_a_second_quoting_its_lease(robot, hold):
    hold(robot.hold("L1"))
    until(lambda: len(robot.renewed) >= 6)
    times = [at for at, _ in robot.renewed[:6]]
    assert times[-1] - times[0] > 0.3
    assert min(later - at for at, later in pairwise(times)) < 0.15
    assert {payload["lease"] for _, payload in robot.renewed} == {"L1"}


def test_release_stops_the_motion_and_renews_no_more(robot, hold, ended):
    holder = hold(robot.hold("L1"))
    until(lambda: robot.renewed)
    holder.release("enough")
    assert robot.stopped == ["enough"]
    assert [ending.good for ending in ended] == [True]
    holder._thread.join(HANG_S)
    assert not holder._thread.is_alive()


def test_drop_renews_no_more_and_stops_nothing(robot, hold):
    holder = hold(robot.hold("L1"))
    until(lambda: robot.renewed)
    holder.drop()
    holder._thread.join(HANG_S)
    assert not holder._thread.is_alive()
    assert robot.stopped == []


def test_a_refused_renewal_ends_the_hold_with_the_robots_reason(robot, hold, ended):
    holder = hold(robot.hold("L1"))
    until(lambda: robot.renewed)
    robot.dead["L1"] = "stopped by web"
    assert holder.wait(HANG_S).text == "stopped by web"
    assert [ending.good for ending in ended] == [False]


def test_the_result_of_a_bounded_move_ends_its_hold(robot, hold):
    holder = hold(robot.hold("L1", goal="g7"))
    until(lambda: robot.renewed)
    robot.finish("another")
    robot.finish("g7", reason="forward is at 40 cm")
    ending = holder.wait(HANG_S)
    assert ending.good
    assert ending.text == "range reached at 40 cm after 1.5 s"


def test_a_result_that_came_before_anybody_listened_is_found(robot, hold):
    robot.finish("g7", "fault", "the sensor is frozen")
    robot.dead["L1"] = "no such lease"
    ending = hold(robot.hold("L1", goal="g7")).wait(HANG_S)
    assert not ending.good
    assert ending.text == "fault at 40 cm after 1.5 s: the sensor is frozen"


def test_a_hold_ends_at_its_longest_time_with_a_stop(robot, hold):
    ending = hold(robot.hold("L1", max_run_s=0.3)).wait(HANG_S)
    assert "longest" in ending.text
    assert len(robot.stopped) == 1


def test_a_robot_that_falls_silent_ends_the_hold(robot, hold, monkeypatch):
    monkeypatch.setattr("lbr.console.lease_keeper.SILENCE_S", 1.0)
    holder = hold(robot.hold("L1"))
    until(lambda: robot.renewed)
    robot.mute = True
    ending = holder.wait(HANG_S)
    assert not ending.good
    assert "does not answer" in ending.text


def test_what_nobody_would_hear_a_stop_of_is_stopped(robot, hold, ended, monkeypatch, wording):
    monkeypatch.setattr("lbr.console.ear.FRESH_S", 0.5)
    holder = hold(robot.hold("L1"), Ear())
    until(lambda: robot.renewed)
    wording(holder.wait(HANG_S).text)
    until(lambda: robot.stopped)
    before = len(robot.renewed)
    holder.join()
    assert (len(robot.renewed), [ending.good for ending in ended]) == (before, [False])


def test_what_else_speaks_against_going_on_stops_it_too(robot, hold):
    ear = Ear(clock=lambda: 0.0)
    holder = hold(robot.hold("L1"), ear)
    until(lambda: len(robot.renewed) > 2)
    ear.also = lambda: "the terminal is gone"
    assert holder.wait(HANG_S).text == "stopped: the terminal is gone"
    until(lambda: robot.stopped == ["the terminal is gone"])


def test_closing_the_session_ends_the_hold(robot, client, hold, ended):
    holder = hold(robot.hold("L1"))
    until(lambda: robot.renewed)
    client.close()
    assert not holder.wait(HANG_S).good


def test_the_end_is_told_once_however_many_end_it(robot, hold, ended):
    holder = hold(robot.hold("L1"))
    threads = [threading.Thread(target=holder.drop) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(ended) == 1


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"result": "reached", "range_cm": 40.0}, "range reached at 40 cm after 2.0 s"),
        ({"result": "reached"}, "what it says"),
        ({"result": "reached", "reason": ""}, "done after 2.0 s"),
        ({"result": "interval"}, "time is over after 2.0 s"),
        ({"result": "reached", "turned_deg": 90.6, "error_deg": 0.6}, "what it says"),
        ({"result": "fault", "turned_deg": 45.0}, "fault after 2.0 s, turned 45.0 degrees: what it says"),
        ({"result": "reached", "distance_m": -1.0, "error_m": 0.0}, "what it says"),
        (
            {"result": "reached", "range_cm": 40.0, "distance_m": 0.8},
            "range reached at 40 cm after 2.0 s, drove 0.80 m",
        ),
        ({"result": "stopped", "distance_m": -0.5}, "stopped after 2.0 s, drove 0.50 m: what it says"),
    ],
)
def test_how_a_move_ended_is_told_in_one_line(fields, told):
    result = GoalResult(**({"goal": "g", "reason": "what it says", "range_cm": None, "elapsed_s": 2.0} | fields))
    assert describe(result) == told
