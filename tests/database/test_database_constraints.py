"""What SQLite refuses is told in words: table, column and what is allowed; never an expression of SQL."""

import re
import sqlite3

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.database import edits
from lbr.database.constraints import refused, words
from lbr.errors import RowError
from lbr.messages.calibration import measured
from lbr.messages.joints import Joint
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


@pytest.mark.parametrize(
    "statement",
    [
        "INSERT INTO capability (robot, name, kind) VALUES ('lbr', 'A', 'k')",
        "UPDATE verb SET role = 'king' WHERE word = 'f'",
        "INSERT OR ABORT INTO verb (robot, word, pattern, target, payload) VALUES ('lbr', 'a', '/a', 'a.b', '3')",
        "INSERT INTO motion (robot, name, slot) VALUES ('lbr', 'a', 3)",
        "UPDATE channel SET history = NULL",
        "UPDATE channel SET history = 'x'",
        "UPDATE robot SET owner = x'ff'",
        "INSERT INTO phrase SELECT * FROM phrase LIMIT 1",
        "INSERT INTO device (robot, name, type, address) VALUES ('gone', 'a', 'b', 'c')",
        "INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES ('lbr', 'gone', 1, 1, '{}')",
    ],
)
def test_a_refused_row_is_told_with_table_column_and_what_is_allowed(client, statement, wording):
    with pytest.raises(sqlite3.IntegrityError) as caught:
        client.execute(statement)
    wording(words(str(caught.value), statement))


def test_what_lbr_itself_writes_is_told_so_too(database, wording):
    with pytest.raises(RowError) as caught:
        edits.learn(database, "lbr", [Joint(name="a", device_id=900, lower_rad=0, upper_rad=1, speed_rps=1)])
    assert str(caught.value) == "joint 'lbr/a': table joint, device_id: must be from 0 to 253"
    with wording.of(RowError):
        edits.learn(database, "lbr", list(measured("gone", {"scale": 1.0})))


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
    assert done.stderr.startswith(f"lbr: {mine}, line {line}: table device, name: ")
    assert not (home / "robot.db").exists()


def test_the_shipped_rows_are_taken_statement_by_statement():
    assert refused(robot_db_sql().read_text()) == ""


@given(st.text(), st.text())
def test_any_message_and_any_statement_have_words(error, statement):
    assert isinstance(words(error, statement), str)
    assert isinstance(words(f"CHECK constraint failed: {error}", statement), str)
