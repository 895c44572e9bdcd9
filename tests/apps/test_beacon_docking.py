"""The table `dock` decides by what the beacon's manoeuvres see: in a room of plain geometry it docks, and gives up in time."""

from random import Random

import pytest

from lbr.messages.beacon import MANOEUVRES
from lbr.operations.beacon import BeaconSettings
from lbr.operations.beacon.manoeuvres import Memory, script
from lbr.operations.beacon.moves import CLOSE_DEG, face
from lbr.operations.beacon.view import STAND, Back, Bend, Ending, GivenUpError, Go, Turn, View
from tests.apps.room_with_dock import DOCK, Room


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


def faced(looks_deg, bend_deg):
    """Have a robot look to 0 that cannot turn on the spot: a bend turns it so far; return where it looks, and what it did."""
    running, now, done = face(0.0), 0.0, []
    action, ending = next(running), None
    while True:
        now += 0.1
        try:
            action = running.send(View(time_s=now, direction_deg=looks_deg, ending=ending))
        except StopIteration:
            return looks_deg, done
        ending = None
        if isinstance(action, Bend):
            looks_deg += bend_deg if action.steer_deg > 0.0 else -bend_deg
            ending = Ending(good=True, text="time is over")
        elif action is not STAND:
            ending = Ending(good=False, text="a wall", code="obstacle")
        if action is not STAND:
            done.append(action)


@pytest.mark.parametrize(("looks_deg", "bend_deg"), [(-40.0, 10.0), (55.0, 11.0)])
def test_where_it_cannot_turn_on_the_spot_it_turns_by_bends_ahead_and_back(looks_deg, bend_deg):
    came_deg, done = faced(looks_deg, bend_deg)
    bends = [one for one in done if isinstance(one, Bend)]
    assert abs(came_deg) <= 2 * CLOSE_DEG
    assert {one.power > 0.0 for one in bends} == {True, False}


def test_bends_that_turn_it_nowhere_are_given_up():
    with pytest.raises(GivenUpError, match="cannot turn there: a wall"):
        faced(90.0, 0.2)


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
    assert all(0.0 < abs(each.power) <= 0.3 and each.seconds <= 2.0 for each in asked if isinstance(each, Bend))


def _any_ending(random: Random) -> Ending | None:
    return random.choice((None, Ending(good=True, text="done"), Ending(good=False, text="blocked", code="obstacle")))
