"""`lbr why` without a robot that answers: the rows and the events of its database do."""

import json
import sqlite3
from contextlib import closing

import pytest

from lbr import cli
from lbr.commands.why import complete_part
from lbr.database import store
from tests.support import databases


@pytest.fixture
def home(tmp_path, monkeypatch):
    place = tmp_path / "home"
    place.mkdir(mode=0o700)
    monkeypatch.setenv("LBR_HOME", str(place))
    return place


@pytest.fixture
def why(capfd, home):
    databases.fresh(home / "robot.db")

    def ask(*arguments: str):
        code = cli.main(["why", *arguments, "--json"])
        out, err = capfd.readouterr()
        return json.loads(out) if code == 0 else (code, err)

    return ask


def test_a_robot_that_does_not_run_is_explained_by_its_rows(why, home):
    found = why("drive")
    assert (found["robot"], found["state"], found["code"], found["source"]) == ("lbr", "held", "unreachable", "rows")
    assert (found["do"].startswith("lbr run"), "never started" in found["text"]) == (True, True)
    with store.Database.open(home / "robot.db") as database:
        database.record_start("lbr")
        assert "was not shut down" in why("drive")["text"]
        database.record_shutdown("lbr")
    found = why("drive")
    assert (found["code"], found["since_s"] < 60.0) == ("shutting_down", True)


def test_the_robot_that_has_such_a_part_is_meant(why):
    assert why("left_knee")["robot"] in {"bioloid", "uxa90"}
    assert why("left_knee", "--robot", "uxa90")["robot"] == "uxa90"
    code, err = why("left_knee", "--robot", "nemo")
    assert (code, "there is no robot 'nemo'" in err) == (2, True)


def test_a_row_that_is_switched_off_is_told_too(why, home):
    with closing(sqlite3.connect(home / "robot.db")) as database, database:
        database.execute("UPDATE capability SET enabled = 0 WHERE name = 'drive'")
    links = why("drive")["links"]
    assert [one["name"] for one in links if one["state"] == "held"] == ["executive", "row"]


def test_it_is_told_in_lines_for_people(why, capfd, wording):
    assert cli.main(["why", "drive"]) == 0
    lines = capfd.readouterr().out.splitlines()
    wording(lines[0])
    assert any(line.startswith("> HOLDS  executive") for line in lines)


def test_without_rows_there_is_nothing_to_answer_from(capfd, home):
    assert cli.main(["why", "drive"]) == 1
    assert "'lbr run' makes them" in capfd.readouterr().err


def test_parts_are_completed_from_the_rows(why):
    assert {"left_knee", "left_elbow"} <= {one.value for one in complete_part(None, None, "left_")}
