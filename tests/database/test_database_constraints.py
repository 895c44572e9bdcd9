"""What SQLite refuses is told in words: table, column and what is allowed; never an expression of SQL."""

import re
import sqlite3

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.database.constraints import refused, words
from lbr.database.store import Database, create
from lbr.errors import RowError
from lbr.messages.calibration import measured
from lbr.resources import robot_db_sql
from tests.support.robot import lbr

CHECKS = re.findall(r"CHECK \((.*)\),?(?:\s*--.*)?$", robot_db_sql().read_text(), re.MULTILINE)
SQL = re.compile(r"constraint failed|GLOB|BETWEEN| IN \(|json_|length\(|CASE")


@pytest.mark.parametrize("check", sorted(set(CHECKS)))
def test_every_check_of_the_schema_has_words(check):
    said = words(f"CHECK constraint failed: {check}", "INSERT INTO some (a) VALUES (?)")
    column = re.match(r"table some, (\w+): must be \S", said)
    assert column is not None, said
    assert column[1] in check
    assert not SQL.search(said)


def test_there_are_as_many_checks_as_the_schema_has():
    assert len(CHECKS) == robot_db_sql().read_text().count("CHECK (")


@pytest.fixture
def client(tmp_path):
    path = tmp_path / "robot.db"
    create(path)
    connection = sqlite3.connect(path)
    connection.execute("PRAGMA foreign_keys = ON")
    yield connection
    connection.close()


@pytest.mark.parametrize(
    ("statement", "says"),
    [
        (
            "INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'A', 'k')",
            "table capability, name: must be a name (small letters, digits, underscores; at most 40), and not 'executive'",
        ),
        (
            "UPDATE verb SET role = 'king' WHERE word = 'f'",
            "table verb, role: must be one of view, operate, admin",
        ),
        (
            "INSERT OR ABORT INTO verb (robot, word, pattern, target, payload) VALUES ('lbr', 'a', '/a', 'a.b', '3')",
            'table verb, payload: must be a JSON object like {"key": 1}, or NULL',
        ),
        (
            "INSERT INTO motion (robot, name, slot) VALUES ('lbr', 'a', 3)",
            "table motion, slot_s: must be above 0 and at most 600 if there is a slot, and NULL if there is none",
        ),
        ("UPDATE channel SET history = NULL", "table channel, history: must not be NULL"),
        ("UPDATE channel SET history = 'x'", "table channel, history: must be a whole number, not a text"),
        ("UPDATE robot SET owner = x'ff'", "table robot, owner: must be a text, not a blob"),
        (
            "INSERT INTO phrase SELECT * FROM phrase LIMIT 1",
            "table phrase has a row with this name, language already: change that row, or take another language",
        ),
        (
            "INSERT INTO device (robot, name, type, address) VALUES ('gone', 'a', 'b', 'c')",
            "table device: robot must be that of a row of 'robot'; add that one first, in the same transaction",
        ),
        (
            "INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES ('lbr', 'gone', 1, 1, '{}')",
            "table motion_step: robot/motion must be that of a row of 'motion'; add that one first, in the same transaction",
        ),
    ],
)
def test_a_refused_row_is_told_with_table_column_and_what_is_allowed(client, statement, says):
    with pytest.raises(sqlite3.IntegrityError) as caught:
        client.execute(statement)
    assert words(str(caught.value), statement) == says


def test_what_lbr_itself_writes_is_told_so_too(tmp_path):
    create(tmp_path / "robot.db")
    with Database.open(tmp_path / "robot.db") as database:
        with pytest.raises(RowError) as caught:
            database.add_rows({"joint": [{"robot": "lbr", "name": "a", "device_id": 900, "lower_rad": 0, "upper_rad": 1,
                                          "speed_rps": 1}]})  # fmt: skip
        assert str(caught.value) == (
            f"database {tmp_path / 'robot.db'} refuses the row: table joint, device_id: must be from 0 to 253"
        )
        with pytest.raises(RowError, match=r"table calibration: robot/device must be that of a row of 'device'"):
            database.learn("lbr", list(measured("gone", {"scale": 1.0})))


def test_rows_of_ones_own_that_are_refused_are_told_with_their_line(home, tmp_path):
    (home / "robot.db").unlink()
    text = robot_db_sql().read_text()
    before, mark, after = text.partition("INSERT INTO device")
    mine = tmp_path / "mine.sql"
    bad = "-- mine\n\nINSERT INTO device (robot, name, type, address)\n  VALUES ('lbr', 'Big One', 'b', 'c');\n"
    mine.write_text(before + bad + mark + after)
    line = before.count("\n") + 3
    done = lbr(home, "db", "init", "--sql", str(mine))
    assert done.returncode == 2
    says = "table device, name: must be a name (small letters, digits, underscores; at most 40)"
    assert done.stderr == f"lbr: {mine}, line {line}: {says}\n"
    assert not (home / "robot.db").exists()


def test_the_shipped_rows_are_taken_statement_by_statement():
    assert refused(robot_db_sql().read_text()) == ""


@given(st.text(), st.text())
def test_any_message_and_any_statement_have_words(error, statement):
    assert isinstance(words(error, statement), str)
    assert isinstance(words(f"CHECK constraint failed: {error}", statement), str)
