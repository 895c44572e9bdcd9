"""What `lbr db` says of rows that are good, odd or changed."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from lbr import home
from lbr.database.store import Database
from lbr.home import Running
from tests.support.commands import db
from tests.support.databases import edit

SHIPPED = Path(__file__).parents[2] / "docs" / "examples"


def hints(path: Path, *edits: str, of: str = "") -> dict[str, list[str]]:
    """Return the hints of each robot that has some, after edits; or those of one robot alone."""
    edit(path, *edits)
    checked = db("check", "--json", *(("--robot", of) if of else ()))
    assert checked.return_value == 0
    return {one["robot"]: one["hints"] for one in json.loads(checked.stdout) if one["hints"]}


def test_differences_are_told_as_json_too(path):
    edit(path, "UPDATE capability SET restart = 'never' WHERE robot = 'lbr' AND name = 'drive'")
    (found,) = json.loads(db("diff", "--json").stdout)
    assert found["columns"] == {"restart": ["on-failure", "never"]}


def test_the_shipped_rows_have_no_hints(path):
    assert hints(path) == {}


@pytest.mark.parametrize(
    "sql",
    [
        "DELETE FROM channel WHERE target = 'drive.ranges'",
        "DELETE FROM range_sensor",
        "UPDATE capability SET enabled = 0 WHERE robot = 'lbr' AND name = 'ranges'",
        "UPDATE capability SET settings = json_set(settings, '$.left.direction', 1) WHERE name = 'motors'",
        """UPDATE capability SET enabled = 1, settings = '{"faces": ["tail"]}' WHERE robot = 'lbr' AND name = 'web'""",
        "UPDATE device SET address = '/dev/video0' WHERE robot = 'lbr' AND name = 'rear_camera'",
    ],
)
def test_what_is_odd_is_a_hint_and_no_fault(path, sql, wording):
    wording(*hints(path, sql, of="lbr")["lbr"])


def test_a_uxa90_whose_servos_are_not_read_is_a_hint(path, wording):
    sql = (
        "UPDATE capability SET settings = json_set(settings, '$.sweep_hz', 0) WHERE robot = 'uxa90' AND kind = 'uxa90'"
    )
    (found,) = hints(path, sql, of="uxa90")["uxa90"]
    wording(found)
    assert f"uxa90: hint: {found}" in db("check", "--robot", "uxa90").stdout


@pytest.mark.parametrize(
    "sql",
    [
        "CREATE TRIGGER sly AFTER UPDATE ON verb BEGIN UPDATE robot SET owner = 'me'; END",
        "CREATE TABLE diary (text)",
    ],
)
def test_what_is_not_of_our_schema_is_a_hint(path, sql, wording):
    (hint,) = hints(path, sql)["schema"]
    wording(hint)


def test_a_table_without_triggers_is_told_with_the_sql_that_makes_them(path):
    table = "CREATE TABLE greeting (robot TEXT NOT NULL, name TEXT NOT NULL, said INTEGER, PRIMARY KEY (robot, name))"
    (lacking,) = hints(path, table)["schema"]
    assert "'greeting'" in lacking
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(lacking.partition("\n\n")[2])
        connection.execute("INSERT INTO greeting VALUES ('lbr', 'ann', 0)")
        connection.execute("UPDATE greeting SET said = 1")
        connection.execute("UPDATE greeting SET said = 1")
        connection.execute("DELETE FROM greeting")
        connection.commit()
        kept = "SELECT row_key, operation, old_row, new_row FROM revision WHERE table_name = 'greeting' ORDER BY id"
        was, now = (f'{{"robot":"lbr","name":"ann","said":{said}}}' for said in (0, 1))
        assert connection.execute(kept).fetchall() == [
            ('["lbr","ann"]', "insert", None, was),
            ('["lbr","ann"]', "update", was, now),
            ('["lbr","ann"]', "delete", now, None),
        ]
    assert all("triggers that keep" not in hint for hint in hints(path, "SELECT 1")["schema"])


def test_code_of_ones_own_is_a_hint(path, wording):
    own = path.parent / "capabilities"
    own.mkdir(mode=0o700)
    (own / "wander.py").write_text((SHIPPED / "wander.py").read_text())
    edit(path, (SHIPPED / "wander.sql").read_text())
    (hint,) = hints(path, of="lbr")["lbr"]
    wording(hint)


def test_a_robot_is_removed_with_all_of_its_rows_and_one_undo_brings_them_back(path):
    with Database.open(path) as database:
        before = database.tables()[0]
    done = db("remove", "bioloid", "--dry-run")
    assert (done.return_value, "robot 'bioloid' removed" in done.stdout) == (0, True)
    assert db("remove", "bioloid").return_value == 0
    with Database.open(path) as database:
        after = database.tables()[0]
        assert database.robots() == ("lbr", "uxa90")
    assert {table for table, rows in after.items() for row in rows if row.get("robot") == "bioloid"} == set()
    assert [row for row in after["capability"] if row["robot"] == "lbr"] == [
        row for row in before["capability"] if row["robot"] == "lbr"
    ]
    assert db("undo").return_value == 0
    with Database.open(path) as database:
        assert database.tables()[0] == before


def test_a_robot_that_runs_or_is_unknown_is_not_removed(path):
    runs = Running(
        robot="bioloid", pid=1, endpoints=(), profile="bioloid-sim", database=str(path), core="", password=""
    )
    lock = home.RunLock("bioloid")
    lock.publish(runs)
    assert db("remove", "bioloid").exception.code == "not_possible"
    lock.release()
    assert db("remove", "bioloit").exception.code == "unknown_name"
    with Database.open(path) as database:
        assert "bioloid" in database.robots()
