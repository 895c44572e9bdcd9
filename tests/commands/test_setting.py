"""`lbr set` changes one setting of one robot's part, checked and to be undone; `lbr get` prints settings."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from click.testing import Result

from lbr.errors import InputError
from tests.support import databases
from tests.support.commands import typed as lbr


@pytest.fixture(autouse=True)
def path(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    return databases.in_home(tmp_path / "home")


def parts(path: Path) -> dict[tuple[str, str], dict]:
    rows = databases.asked(path, "SELECT robot, name, settings FROM capability")
    return {(robot, name): json.loads(settings) for robot, name, settings in rows}


def code_of(done: Result) -> str:
    assert isinstance(done.exception, InputError)
    return done.exception.code


def test_one_setting_of_one_row_changes_and_is_undone(path):
    before = parts(path)
    done = lbr("set", "web.port", "50009")
    assert done.return_value == 0
    assert "lbr, at its next start: restart web" in done.stdout.splitlines()
    changed = before | {("lbr", "web"): before["lbr", "web"] | {"port": 50009}}
    assert parts(path) == changed != before
    assert lbr("get", "web.port").stdout == "50009\n"
    assert lbr("db", "undo").return_value == 0
    assert parts(path) == before


def test_the_named_robot_and_database_alone_are_changed(path, tmp_path):
    other = tmp_path / "other.db"
    databases.fresh(other)
    before = parts(path)
    assert lbr("set", "web.port", "50009", "--robot", "bioloid", "--db", str(other)).return_value == 0
    assert parts(path) == before
    assert parts(other) == before | {("bioloid", "web"): before["bioloid", "web"] | {"port": 50009}}
    assert lbr("get", "web.port", "--robot", "bioloid", "--db", str(other)).stdout == "50009\n"


@pytest.mark.parametrize(
    ("setting", "value"),
    [("drive.max_power", "3"), ("drive.max_power", "-0.1"), ("drive.max_power", "NaN"), ("drive.max_power", "fast"),
     ("drive.max_powr", "0.3"), ("drive.", "1"), ("drive", "1"), ("", "1"), ("no_such.part", "1"),
     ("drive.max_power", '{"a": 1, "a": 2}'), ("drive.max_power", "")],
)  # fmt: skip
def test_what_a_start_would_refuse_changes_nothing(path, setting, value):
    before = parts(path)
    done = lbr("set", setting, value)
    assert done.return_value == 2 or isinstance(done.exception, InputError)
    assert parts(path) == before


@pytest.mark.parametrize(
    ("setting", "value", "meant"),
    [
        ("web.faces", '["page"]', ["page"]),
        ("drive.mixing", "clamped", "clamped"),
        ("drive.mixing", '"clamped"', "clamped"),
    ],
)
def test_a_value_is_json_or_a_text(path, setting, value, meant):
    assert lbr("set", setting, value).return_value == 0
    part, _, name = setting.partition(".")
    assert parts(path)["lbr", part][name] == meant


def test_a_dry_run_and_an_old_revision_write_nothing(path):
    before = parts(path)
    said = json.loads(lbr("set", "drive.max_power", "0.3", "--dry-run", "--json").stdout)
    assert (said["written"], said["touched"][0]["restart"]) == (False, ["drive"])
    assert code_of(lbr("set", "drive.max_power", "0.3", "--revision", "7")) == "changed"
    assert parts(path) == before


def test_settings_are_listed_with_where_they_come_from():
    lbr("set", "drive.max_power", "0.3")
    all_of_drive = {one["setting"]: one for one in json.loads(lbr("get", "drive", "--json").stdout)}
    assert all_of_drive["max_power"] == {"part": "drive", "setting": "max_power", "value": 0.3, "in_row": True}
    assert not all_of_drive["ttl_s"]["in_row"]
    every = json.loads(lbr("get", "--json").stdout)
    assert all(one["in_row"] for one in every)
    assert "drive.max_power" in {f"{one['part']}.{one['setting']}" for one in every}


@pytest.mark.parametrize("setting", ["no_such", "no_such.part", "drive.no_such"])
def test_a_part_and_a_setting_that_are_not_there_are_refused(setting):
    assert code_of(lbr("get", setting)) == "unknown_name"


def test_a_row_whose_settings_are_not_valid_is_printed_as_it_is(path):
    with closing(sqlite3.connect(path, isolation_level=None)) as client:
        client.execute("UPDATE capability SET settings = '{\"no_such\": 1}' WHERE robot = 'lbr' AND name = 'drive'")
    assert lbr("get", "drive").stdout == "drive.no_such 1\n"
