"""Docking decides by what it sees: in a room of plain geometry it docks, gives up, and lets itself be stopped."""

from random import Random

import pytest

from lbr.apps.autodock.script import Manner, dock
from lbr.apps.autodock.view import STAND, Back, Go, Say, Turn, View
from tests.apps.room_with_dock import DOCK, Room


def test_it_docks_from_where_the_robot_starts():
    room = Room()
    ending = room.run()
    assert ending.good
    assert "being charged" in ending.text
    assert room.touching()
    assert room.now < 60.0
    assert room.said == ["docking", "docked"]


@pytest.mark.parametrize("seed", range(40))
def test_it_docks_from_wherever_it_is_let_go(seed):
    random = Random(seed)
    room = Room(random.uniform(-0.5, 2.5), random.uniform(-1.8, 1.8), random.uniform(-180.0, 180.0))
    ending = room.run(Manner(side=random.choice(("left", "right"))))
    assert ending.good, ending.text
    assert room.touching()
    assert room.now < 120.0


def test_on_its_dock_it_stays():
    room = Room(DOCK[0] + 0.215, DOCK[1])
    room.contact_at = -100.0
    ending = room.run()
    assert ending.good
    assert room.now < 1.0
    assert room.touching()


def test_without_a_dock_it_gives_up_and_says_so():
    room = Room()
    room.dock_there = False
    ending = room.run()
    assert not ending.good
    assert "no beam of the dock was seen" in ending.text
    assert room.said == ["docking", "dock_failed"]
    assert room.now < 180.0


def test_contacts_without_current_are_told():
    room = Room(charger=False)
    ending = room.run()
    assert not ending.good
    assert "is not being charged" in ending.text
    assert room.touching()


def test_who_stops_it_has_the_last_word():
    room = Room()
    room.refuse, room.final = "stopped by console: enough", True
    ending = room.run()
    assert ending.text == "stopped by console: enough"
    assert (room.x_m, room.y_m) == (0.0, 0.0)
    assert room.now < 3.0


def test_a_robot_that_cannot_move_does_not_try_for_ever():
    room = Room()
    room.refuse = "the motors are not armed"
    ending = room.run()
    assert not ending.good
    assert room.now < 120.0


@pytest.mark.parametrize("seed", range(20))
def test_whatever_it_sees_it_comes_to_an_end_and_asks_for_nothing_absurd(seed):
    random = Random(seed)
    script, now, asked = dock(Manner()), 0.0, []
    action = next(script)
    while now < 3000.0:
        now += 0.1
        asked.append(action)
        view = View(
            time_s=now,
            direction_deg=random.uniform(-180.0, 180.0),
            back_m=random.choice((None, 0.2, 1.0, 7.0)),
            forward_m=random.choice((None, 0.2, 7.0)),
            beams=frozenset(random.sample(("left", "right"), random.randrange(3))),
            rest_voltage_v=random.choice((None, 12.0, 13.0)),
            ending=None if action is STAND or isinstance(action, Say | Back) else _any_ending(random),
        )
        try:
            action = script.send(view)
        except StopIteration:
            break
    assert now < 3000.0
    assert isinstance(asked[-1], Say)
    assert all(abs(each.angle_deg) <= 180.0 for each in asked if isinstance(each, Turn))
    assert all(0.0 < each.power <= 0.3 for each in asked if isinstance(each, Go | Back))


def _any_ending(random: Random):
    from lbr.apps.autodock.view import Ending

    return random.choice((None, Ending(good=True, text="done"), Ending(good=False, text="blocked")))
