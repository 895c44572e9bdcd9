"""Tables of humanoids, tried in lockstep: the robot's own joints, motions and tables move its simulated body."""

import json
import tempfile
from pathlib import Path

import pytest
from msgspec.structs import replace

from lbr.apps.behaviours.commands.trials import setup_of
from lbr.commands.rows import opened
from lbr.messages.behaviour import BehaviourRow, BehaviourTable
from lbr.simulation.trials.faults import BODY
from lbr.simulation.trials.trying import made
from tests.support import needs
from tests.support.robot import lbr, prepare

needs.modules("mujoco")


@pytest.fixture(scope="module")
def home():
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield prepare(Path(place) / "h", whole=True)


def setup(home, robot, name, lines=(), max_s=60.0):
    with opened(home / "robot.db") as database:
        rows = database.load(robot)
    own = tuple(row for row in rows.of(BehaviourRow) if row.behaviour == name)
    given = tuple(BehaviourRow(behaviour=name, step=at, **line) for at, line in enumerate(lines, start=1))
    return setup_of(rows, BehaviourTable(name=name), given or own, max_s, str(home))


def played(motion):
    return (
        {"type": "start", "state": "On", "outputs": {"motion": motion}, "next_state": "There"},
        {"type": "end", "state": "There"},
    )


@pytest.mark.parametrize("robot", ["bioloid", "uxa90"])
def test_a_table_that_gets_it_up_begins_fallen_and_ends_on_its_feet(home, robot):
    of = setup(home, robot, "get_up")
    outcome = made(of, 0, "", 1).run()
    assert (outcome.began, outcome.good, outcome.state) == ("lying on its face", True, "Upright")
    assert (outcome.stands, outcome.unsafe) == (True, ())


def test_others_begin_standing_and_a_seed_makes_the_same_trial_again(home):
    of = setup(home, "bioloid", "once", played("sit"))
    first, again, other = (made(of, number, "", 7).run() for number in (3, 3, 4))
    assert first == again
    assert first != replace(other, number=3)
    assert (first.began, first.good, first.falls, first.stands) == ("standing", True, 0, False)


def test_what_the_main_board_plays_moves_it_and_is_over_for_the_table(home):
    outcome = made(setup(home, "uxa90", "once", played("walk_forward_4step")), 0, "", 1).run()
    assert (outcome.good, outcome.stands) == (True, True)
    assert 3.0 < outcome.took_s < 6.0
    assert outcome.moved_m > 0.15


def test_a_fault_is_there_from_its_time_on(home):
    of = setup(home, "bioloid", "get_up")
    assert made(of, 0, "attitude lost in a motion", 1).run().state == "Blind"
    pushed = made(replace(of, begins="standing"), 0, "pushed", 1)
    pushed.rounds(BODY["pushed"].pushed_s + 1.0)
    assert pushed.moved_m > 0.02


def test_the_command_says_how_often_it_stood(home):
    done = lbr(home, "behaviour", "try", "get_up", "--robot", "bioloid", "--only", "0", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert (said["trial"]["good"], said["trial"]["stands"]) == (True, True)
