"""What `lbr db history`, `diff`, `rollback` and `undo` say of rows' past."""

import json
import os
import pwd
from pathlib import Path

import pytest

from tests.support import databases
from tests.support.commands import db
from tests.support.databases import edit

POWER = "UPDATE capability SET settings = json_set(settings, '$.max_power', 0.5) WHERE robot = 'lbr' AND name = 'drive'"
OWNER = "UPDATE robot SET owner = 'me' WHERE name = 'bioloid'"
ME = pwd.getpwuid(os.getuid()).pw_name


def owner(path: Path) -> str:
    ((owner,),) = databases.asked(path, "SELECT owner FROM robot WHERE name = 'bioloid'")
    return owner


def test_history_says_who_changed_which_rows_when_and_by_what(path):
    edit(path, POWER, OWNER)
    assert db("rollback", "1").return_value == 0
    first, *rest = db("history").stdout.splitlines()
    assert first.startswith("1-2  2")
    assert first.endswith("another SQLite client")
    power, name, second, back = rest
    assert power.startswith("    capability 'lbr/drive' changed: settings: ")
    assert name == "    robot 'bioloid' changed: owner:  -> me"
    assert second.startswith("3  2")
    assert second.endswith(f"  {ME}, lbr db rollback: went back to revision 1")
    assert back == "    robot 'bioloid' changed: owner: me -> "


@pytest.mark.parametrize(
    "words",
    [("--robot", "bioloid"), ("--table", "robot"), ("--row", "bioloid"), ("-n", "1"), ("--table", "robot", "-n", "1")],
)
def test_history_of_some_rows_leaves_out_the_others(path, words):
    edit(path, POWER, OWNER)
    (change,) = json.loads(db("history", *words, "--json").stdout)
    assert change["rows"][-1]["row"] == "bioloid"
    assert len(json.loads(db("history", "--row", "drive", "--json").stdout)[0]["rows"]) == 1


def test_history_says_when_there_is_none(path):
    assert db("history").stdout == "no row was changed\n"
    assert db("history", "--row", "x").stdout == "no such row was changed\n"
    assert "no table 'x' keeps its changes: behaviour" in str(db("history", "--table", "x").exception)


def test_diff_compares_revisions(path):
    edit(path, POWER, OWNER)
    assert db("diff", "1").stdout == "robot 'bioloid' changed: owner:  -> me\n"
    assert db("diff", "2", "1").stdout == "robot 'bioloid' changed: owner: me -> \n"
    assert db("diff", "2").stdout == "nothing differs\n"
    assert "no revision 3" in str(db("diff", "3").exception)


def test_undo_takes_back_the_newest_change_and_once_more_takes_that_back(path, wording):
    edit(path, OWNER)
    done = db("undo")
    assert (done.return_value, done.stdout) == (
        0,
        "robot 'bioloid' changed: owner: me -> \nthe newest change is taken back: revision 2\n",
    )
    assert owner(path) == ""
    db("undo")
    assert owner(path) == "me"
    db("undo", "2")
    assert owner(path) == "me"
    wording(db("undo", "9").exception)


def test_undo_takes_back_what_a_robot_left_on_trial(path, wording):
    edit(path, OWNER, "INSERT INTO trial (revision, back, robot, within_s) VALUES (1, 0, 'lbr', 5)")
    assert db("undo", "--dry-run").return_value == 0
    assert owner(path) == "me"
    wording(db("undo").stdout)
    assert owner(path) == ""


def test_a_dry_run_says_what_would_be_done(path, wording):
    edit(path, OWNER)
    done = db("rollback", "0", "--dry-run")
    wording(done.stdout.splitlines()[-1])
    assert owner(path) == "me"
    assert "have revision 1, not 0" in str(db("rollback", "0", "--revision", "0").exception)
    wording(db("rollback", "1").stdout)
    assert "there is no robot 'nobody_here'" in str(db("rollback", "0", "--robot", "nobody_here").exception)


def test_rows_that_would_not_start_are_refused(path):
    edit(
        path,
        "INSERT INTO channel (robot, source, target) VALUES ('lbr', 'no.state', 'drive.motors')",
        "DELETE FROM channel WHERE source = 'no.state'",
    )
    refused = db("rollback", "1")
    assert refused.return_value == 2
    assert "problem: channel 'lbr/no.state/drive.motors', source" in refused.stderr
    assert refused.stderr.endswith("nothing was changed\n")
    assert json.loads(db("rollback", "1", "--json").stdout)["written"] is False
    assert db("diff", "2").stdout == "nothing differs\n"
