"""On its feet: stopped in mid-step the simulated humanoids stay there, and rows say where they stand."""

import json
import sqlite3
from contextlib import closing

import pytest

from tests.support import needs

needs.modules("mujoco")

from lbr.apps.motions.commands import motion  # noqa: E402
from lbr.apps.motions.commands import standing as motion_standing  # noqa: E402
from lbr.messages.joints import KeyFrame  # noqa: E402
from tests.models import feet  # noqa: E402
from tests.support import databases  # noqa: E402

FALLS = {"left_hip_pitch": 1.2, "right_hip_pitch": 1.2}


def look(path, query):
    with closing(sqlite3.connect(path)) as connection, connection:
        return connection.execute(query).fetchall()


@pytest.mark.parametrize(("robot", "what"), [("bioloid", "walk_ahead"), ("uxa90", 4)])
def test_stopped_or_left_by_its_sender_in_mid_step_it_steps_to_its_feet_and_stays_there(robot, what):
    ends = [feet.stopped(robot, what, seed, lapse=seed == 2) for seed in (1, 2)]
    assert ends == [(True, "to_feet")] * 2


def test_a_frame_in_which_it_would_fall_is_not_stable():
    joints, motions, settings = feet.known("bioloid")
    initial = next(one for one in motions if one.name == "initial").frames
    frames = (*initial, KeyFrame(positions=FALLS, duration_s=1.0))
    assert list(motion_standing.stable_frames(settings, joints, "/nonexistent", (), frames)) == [True, False]


def test_the_command_finds_where_it_stands_and_writes_it_down(tmp_path, capsys):
    path = tmp_path / "robot.db"
    databases.fresh(path)
    look(path, "UPDATE motion_step SET stable = 0 WHERE robot = 'bioloid'")
    arguments = ["stable", "ready", "--robot", "bioloid", "--db", str(path)]
    for more, kept in ((["--dry-run", "--json"], 0), (["--json"], 1)):
        assert motion.command(args=[*arguments, *more], standalone_mode=False) == 0
        assert json.loads(capsys.readouterr().out) == [{"name": "ready", "frames": 1, "stable": [1]}]
        assert look(path, "SELECT sum(stable) FROM motion_step WHERE robot = 'bioloid'") == [(kept,)]
