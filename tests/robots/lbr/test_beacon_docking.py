"""The table `dock` decides by what the beacon's manoeuvres see: in a room of plain geometry it docks, and gives up in time."""

from random import Random

import pytest

from lbr.messages.beacon import MANOEUVRES
from lbr.robots.lbr.beacon import BeaconSettings
from lbr.robots.lbr.beacon.manoeuvres import Memory, script
from lbr.robots.lbr.beacon.view import STAND, Back, Ending, Go, Turn, View
from tests.robots.lbr.room_with_dock import DOCK, Room


def test_it_docks_from_where_the_robot_starts():
    room = Room()
    ending = room.run()
    assert ending.good, ending.text
    assert room.state == "Docked"
    assert room.touching()
    assert room.now < 60.0
    assert room.said == ["docking", "docked"]


@pytest.mark.parametrize("seed", range(20))
def test_it_docks_from_wherever_it_is_put(seed):
    random = Random(seed)
    room = Room(random.uniform(-0.5, 2.5), random.uniform(-1.8, 1.8), random.uniform(-180.0, 180.0))
    ending = room.run(BeaconSettings(side=random.choice(("left", "right"))))
    assert ending.good, ending.text
    assert room.touching()
    assert room.now < 120.0


def test_on_its_dock_it_stays():
    room = Room(DOCK[0] + 0.215, DOCK[1])
    room.contact_at = -100.0
    ending = room.run()
    assert ending.good
    assert room.now < 2.0
    assert room.touching()


def test_without_a_dock_it_gives_up_and_says_so():
    room = Room()
    room.dock_there = False
    ending = room.run()
    assert (ending.good, room.state) == (False, "No beam")
    assert room.said == ["docking", "dock_failed"]
    assert room.now < 300.0


def test_contacts_without_current_are_told():
    room = Room(charger=False)
    ending = room.run()
    assert (ending.good, room.state) == (False, "Not charging")
    assert room.touching()


def test_who_stops_it_has_the_last_word():
    room = Room()
    room.refuse, room.code = "stopped by console: enough", "stopped"
    ending = room.run()
    assert (ending.text, ending.code) == ("stopped by console: enough", "stopped")
    assert (room.x_m, room.y_m) == (0.0, 0.0)
    assert room.now < 4.0


def test_a_robot_that_cannot_move_does_not_try_for_ever():
    room = Room()
    room.refuse = "the motors are not armed"
    ending = room.run()
    assert (ending.good, room.state) == (False, "Not reached")
    assert room.now < 300.0


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("manoeuvre", MANOEUVRES)
def test_whatever_it_sees_a_manoeuvre_comes_to_an_end_and_asks_for_nothing_absurd(manoeuvre, seed):
    random = Random(seed)
    memory = Memory("left", random.choice((-1.0, 0.0, 1.0)))
    running, now, asked = script(manoeuvre, BeaconSettings(), memory), 0.0, []
    action, ending = next(running), None
    while now < 3000.0 and ending is None:
        now += 0.1
        asked.append(action)
        view = View(
            time_s=now,
            direction_deg=random.uniform(-180.0, 180.0),
            back_m=random.choice((None, 0.2, 1.0, 7.0)),
            forward_m=random.choice((None, 0.2, 7.0)),
            beams=frozenset(random.sample(("left", "right"), random.randrange(3))),
            ending=None if action is STAND or isinstance(action, Back) else _any_ending(random),
        )
        try:
            action = running.send(view)
        except StopIteration as end:
            ending = end.value
    assert ending is not None
    assert ending.good == (ending.code == "done")
    assert all(abs(each.angle_deg) <= 180.0 for each in asked if isinstance(each, Turn))
    assert all(0.0 < each.power <= 0.3 for each in asked if isinstance(each, Go | Back))


def _any_ending(random: Random) -> Ending | None:
    return random.choice((None, Ending(good=True, text="done"), Ending(good=False, text="blocked", code="obstacle")))
