"""A whole robot for a test of one's own, as `lbr.testing.robot` gives it."""

import json
import sqlite3
from contextlib import closing

import pytest

from lbr.testing.robot import running
from tests.support.robot import BASE, only
from tests.support.waiting import until


def test_it_runs_hears_lines_and_questions_and_leaves_nothing():
    creep = {"power": 0.1, "angle_deg": 0}
    verb = (
        "INSERT INTO verb (robot, word, pattern, target, payload, help)"
        f" VALUES ('lbr', 'creep', 'creep', 'drive.command', '{json.dumps(creep)}', 'Drive ahead slowly')"
    )
    with running(edits=(only("lbr", *BASE), verb)) as robot:
        until(lambda: robot.say("creep")["code"] == 0, what="it creeps")
        assert robot.ask("@status")["robot"] == "lbr"
        assert robot.say("creep", "view")["code"] != 0, "a viewer moves nothing"
        with closing(sqlite3.connect(robot.home / "robot.db")) as database:
            assert database.execute("SELECT count(*) FROM verb WHERE word = 'creep'").fetchone() == (1,)
        assert robot.say("stop")["code"] == 0
    assert robot.popen.returncode == 0
    assert not robot.home.exists()


def test_one_that_cannot_start_says_why():
    with pytest.raises(AssertionError, match="no-such-profile"), running("no-such-profile"):
        pass
