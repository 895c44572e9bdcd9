"""Tables tried in lockstep: the robot's own capabilities in its world, by a clock of its own."""

import json
import sys
import tempfile
from math import atan2, degrees, hypot, radians, remainder, tau
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from lbr.apps.behaviours.commands.trials import setup_of
from lbr.commands.rows import opened
from lbr.messages.behaviour import BehaviourRow, BehaviourState, BehaviourTable
from lbr.simulation.requests import BallRequest
from lbr.simulation.settings import StartPose
from lbr.simulation.trials.faults import EVERY
from lbr.simulation.trials.trial import Setup, Trial
from lbr.simulation.trials.trying import made
from tests.support import programs
from tests.support.robot import lbr, prepare


@pytest.fixture(scope="module")
def home():
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield prepare(Path(place) / "h", whole=True)


@pytest.fixture(scope="module")
def rows(home):
    with opened(home / "robot.db") as database:
        return database.load("lbr")


def setup(rows, home, name, lines=(), max_s=60.0):
    table = BehaviourTable(name=name)
    own = tuple(row for row in rows.of(BehaviourRow) if row.behaviour == name)
    given = tuple(BehaviourRow(behaviour=name, step=at, **line) for at, line in enumerate(lines, start=1))
    return setup_of(rows, table, given or own, max_s, str(home))


AHEAD = (
    {
        "type": "start",
        "state": "Going",
        "outputs": {"level": "0.4", "angle": "0", "distance": "100"},
        "next_state": "There",
    },
    {"type": "end", "state": "There"},
)


def test_a_table_moves_the_robot_of_its_world_and_ends(rows, home):
    trial = Trial(setup(rows, home, "ahead", AHEAD), 0, StartPose())
    outcome = trial.run()
    assert (outcome.good, outcome.state, outcome.unsafe) == (True, "There", ())
    assert trial.instruments.pose.x_m == pytest.approx(1.0, abs=0.05)
    assert 2.0 < outcome.took_s < 10.0


def test_the_same_seed_gives_the_same_trial_and_another_place_another(rows, home):
    of = setup(rows, home, "pace", max_s=15.0)
    first, again, other = (made(of, number, "", 7).run() for number in (3, 3, 4))
    assert first == again
    assert first.start != other.start


def test_the_robot_docks_with_the_drive_and_the_beacon_that_it_has(rows, home):
    outcome = made(setup(rows, home, "dock", max_s=300.0), 0, "", 1).run()
    assert outcome.good, outcome
    assert outcome.charging
    assert outcome.contact_mps < 0.4


def test_it_finds_the_dock_past_a_crate_that_hides_the_wall(rows, home):
    hard = StartPose(x_m=2.0, y_m=-1.5, yaw_rad=radians(160.0))
    outcome = Trial(setup(rows, home, "dock", max_s=600.0), 1, hard).run()
    assert outcome.good, outcome
    assert outcome.charging


def test_ranges_that_end_on_the_way_end_the_motion_and_the_table_says_where(rows, home):
    at_once = replace(EVERY["ranges dead on the way"], blind_s=3.0)
    outcome = Trial(setup(rows, home, "ahead", AHEAD), 0, StartPose(), faults=at_once).run()
    assert not outcome.good
    assert (outcome.code, outcome.row, outcome.unsafe) == ("stale_sensor", 1, ())
    assert outcome.moved_m < 0.9


def test_what_drives_against_a_wall_is_stopped_by_the_rules_and_told(rows, home):
    far = (AHEAD[0] | {"outputs": {"level": "0.5", "angle": "0", "distance": "600"}}, AHEAD[1])
    outcome = Trial(setup(rows, home, "far", far), 0, StartPose()).run()
    assert (outcome.good, outcome.code) == (False, "obstacle")
    assert outcome.contact_mps == 0.0


def test_what_goes_on_at_the_end_of_its_time_is_stopped_and_counts_as_good(rows, home):
    turning = (
        {"type": "start", "state": "Turning", "conditions": {"Run Time": "> 1000"}, "next_state": "Never"},
        {"state": "Turning", "outputs": {"turn": "90"}, "next_state": "Turning"},
        {"type": "end", "state": "Never"},
    )
    of = setup(rows, home, "turns", turning, 6.0)
    outcome = Trial(of, 0, StartPose()).run()
    assert (outcome.good, outcome.code, outcome.unsafe) == (True, "time_over", ())


def test_the_setup_survives_its_way_to_another_process(rows, home):
    of = setup(rows, home, "ahead", AHEAD)
    assert msgspec.json.encode(msgspec.json.decode(msgspec.json.encode(of), type=Setup)) == msgspec.json.encode(of)


def test_the_command_tries_a_file_and_says_what_became_of_it(home, tmp_path):
    table = tmp_path / "ahead.csv"
    table.write_text(
        "Type,Current State,O:level,O:angle,O:distance,Next State\n"
        "start,Going,0.4,0,100,There\nend,There,,,,\nfail,Stuck,,,,\n"
    )
    before = (home / "robot.db").read_bytes()
    said = lbr(
        home, "behaviour", "try", str(table), "--runs", "2", "--jobs", "1", "--json", "--for", "20", limit_s=25.0
    )
    told = json.loads(said.stdout)
    assert [one["number"] for one in told["trials"]] == [0, 1]
    assert told["trials"][0]["good"]
    story = lbr(home, "behaviour", "try", str(table), "--only", "0")
    assert "good after" in story.stdout
    assert "drive: behaviour took the base" in story.stdout
    assert (home / "robot.db").read_bytes() == before


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("nothing_of_the_kind",), "has no behaviour 'nothing_of_the_kind'"),
        (("pace", "--only", "0", "--fault", "bad weather"), "there is no fault 'bad weather'"),
        (("pace", "--fault", "wheels slip"), "--fault goes with --only"),
    ],
)
def test_what_cannot_be_tried_says_why(home, words, says):
    said = lbr(home, "behaviour", "try", *words)
    assert said.returncode != 0
    assert says in said.stderr


def test_nothing_of_the_bus_is_opened(rows, home):
    script = (
        "import sys, zenoh\nzenoh.open = None\nimport msgspec\nfrom lbr.simulation.trials.trial import Setup, Trial\n"
        "from lbr.simulation.settings import StartPose\n"
        "print(Trial(msgspec.json.decode(sys.stdin.buffer.read(), type=Setup), 0, StartPose()).run().good)"
    )
    of = msgspec.json.encode(setup(rows, home, "ahead", AHEAD))
    done = programs.run([sys.executable, "-c", script], input=of, capture_output=True, check=True)
    assert done.stdout.decode().strip() == "True"


class WithABall(Trial):
    """A trial in which a ball is put somewhere, and elsewhere at its time."""

    places: tuple = ()

    def round(self):
        while self.places and self.board.now >= self.places[0][0]:
            (_, x_m, y_m), *rest = self.places
            self.engine.balls.put(BallRequest(x_m=x_m, y_m=y_m))
            self.places = tuple(rest)
        super().round()

    def away(self):
        """How far the ball is, and how far aside in degrees."""
        x, y, _ = self.engine.balls.middle("ball", 0.0)
        pose = self.instruments.pose
        aside = remainder(atan2(y - pose.y_m, x - pose.x_m) - pose.yaw_rad, tau)
        return hypot(x - pose.x_m, y - pose.y_m), degrees(aside)


@pytest.mark.parametrize("start", [StartPose(), StartPose(x_m=0.5, yaw_rad=radians(200.0))])
def test_it_goes_up_to_a_ball_and_after_it_when_it_is_elsewhere(rows, home, start):
    trial = WithABall(setup(rows, home, "follow", max_s=70.0), 0, start)
    began = trial.board.now
    trial.places = ((began, 2.2, 0.3), (began + 30.0, 0.6, -0.9))
    at_the_first = []
    trial.board.listen(
        "lbr/behaviour/state", BehaviourState, lambda state: at_the_first.append((trial.board.now, state.state))
    )
    outcome = trial.run()
    assert (outcome.code, outcome.state, outcome.unsafe) == ("time_over", "Near", ()), outcome
    assert "Near" in {state for at, state in at_the_first if at < began + 30.0}
    distance_m, aside_deg = trial.away()
    assert 0.6 < distance_m < 1.1
    assert abs(aside_deg) < 13.0


def test_without_a_ball_it_looks_all_around_and_gives_up(rows, home):
    trial = Trial(setup(rows, home, "follow", max_s=200.0), 0, StartPose())
    outcome = trial.run()
    assert (outcome.good, outcome.state, outcome.unsafe) == (False, "Lost", ()), outcome
    assert outcome.moved_m < 0.5


def test_one_that_came_there_in_short_moves_and_waits_is_not_stuck(rows, home):
    trial = WithABall(setup(rows, home, "follow", max_s=64.0), 0, StartPose())
    trial.places = ((trial.board.now, 1.9, -0.6),)
    outcome = trial.run()
    assert (outcome.good, outcome.code, outcome.state) == (True, "time_over", "Near"), outcome
