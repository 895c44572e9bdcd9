"""Every schema that was ever released becomes today's, and loses nothing."""

import re
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from lbr.database.shipped import shipped
from lbr.database.store import Database, create
from lbr.messages.sensing import RING, RangeSensor, ring

RELEASED = sorted((Path(__file__).parent / "released").glob("*.sql"))
STRUCTURE = "SELECT type, name, tbl_name FROM sqlite_schema WHERE name NOT LIKE 'sqlite%' ORDER BY 1, 2"
COLUMNS = "SELECT t.name, c.* FROM pragma_table_list AS t, pragma_table_info(t.name) AS c WHERE t.schema = 'main'"
TRIGGERS = "SELECT name, sql FROM sqlite_schema WHERE type = 'trigger' ORDER BY name"


def shape(path: Path) -> list[object]:
    """Tables, columns and triggers, without comments and white space."""
    with closing(sqlite3.connect(path)) as connection:
        triggers = [(name, " ".join(re.sub(r"--.*", "", sql).split())) for name, sql in connection.execute(TRIGGERS)]
        return [connection.execute(STRUCTURE).fetchall(), sorted(connection.execute(COLUMNS).fetchall()), triggers]


def columns(connection: sqlite3.Connection) -> dict[str, list[str]]:
    """The columns of the tables that make robots and are there."""
    names = {
        table: connection.execute(f"SELECT name FROM pragma_table_info('{table}')").fetchall() for table in shipped()[1]
    }
    return {table: [name for (name,) in found] for table, found in names.items() if found}


WORDS_OF_EVERY_ROBOT = {
    "s",
    "S",
    "stop",
    "estop",
    "/estop/{reason...}",
    "reset",
    "status",
    "help",
    "/help/{word}",
    "Shutdown",
}
"""These were rows, up to the schema 0006."""


def rows(connection: sqlite3.Connection, wanted: dict[str, list[str]]) -> dict[str, list[object]]:
    """Every row, in this many columns, but for the words that rows no longer give."""
    marks = ", ".join(f"'{pattern}'" for pattern in sorted(WORDS_OF_EVERY_ROBOT))
    but = {"verb": f" WHERE pattern NOT IN ({marks})"}
    return {
        table: sorted(
            connection.execute(f"SELECT {', '.join(names)} FROM {table}{but.get(table, '')}").fetchall(), key=repr
        )
        for table, names in wanted.items()
    }


@pytest.mark.parametrize("sql", RELEASED, ids=lambda path: path.stem)
def test_a_released_schema_is_upgraded_to_the_shipped_one(tmp_path, sql):
    create(tmp_path / "old.db", sql)
    create(tmp_path / "new.db")
    with Database.open(tmp_path / "old.db") as database:
        assert database.backup == tmp_path / f"old.db.backup-{sql.stem}"
        assert database.load("lbr").problems == ()
    assert shape(tmp_path / "old.db") == shape(tmp_path / "new.db")


@pytest.mark.parametrize("sql", RELEASED, ids=lambda path: path.stem)
def test_an_upgrade_changes_no_row(tmp_path, sql):
    create(tmp_path / "old.db", sql)
    with closing(sqlite3.connect(tmp_path / "old.db")) as connection:
        there = columns(connection)
        before = rows(connection, there)
    with Database.open(tmp_path / "old.db") as database:
        assert database.revisions() == ()
    with closing(sqlite3.connect(tmp_path / "old.db")) as connection:
        assert rows(connection, there) == before
        added = {table: names for table, names in columns(connection).items() if table not in there}
        found = rows(connection, added)
        assert {(robot, name) for robot, name, *_ in found.pop("range_sensor")} == {("lbr", name) for name in RING}
        assert not any(found.values())


@pytest.mark.parametrize("sql", RELEASED, ids=lambda path: path.stem)
def test_an_upgrade_makes_rows_of_the_five_sensors_that_were_in_the_code(tmp_path, sql):
    create(tmp_path / "old.db", sql)
    create(tmp_path / "new.db")
    with Database.open(tmp_path / "old.db") as old, Database.open(tmp_path / "new.db") as new:
        assert old.load("lbr").of(RangeSensor) == new.load("lbr").of(RangeSensor)


def test_robots_of_others_get_the_five_where_their_base_has_them(tmp_path):
    create(tmp_path / "old.db", RELEASED[0].with_name("0007.sql"))
    with closing(sqlite3.connect(tmp_path / "old.db")) as connection:
        connection.executescript("""
            INSERT INTO robot (name) VALUES ('wide'), ('walker'), ('plain');
            INSERT INTO capability (robot, name, kind, settings) VALUES
                ('wide', 'base', 'drive', '{"body_length_m": 0.6, "body_width_m": 0.5}'),
                ('plain', 'sonar', 'ultrasonic_ring', '{"device": "board"}'),
                ('walker', 'joints', 'joints', '{}');
        """)
    with Database.open(tmp_path / "old.db") as database:
        wide, plain = (
            sorted(database.load(name).of(RangeSensor), key=lambda row: row.name) for name in ("wide", "plain")
        )
        assert database.load("walker").of(RangeSensor) == ()
    assert wide == sorted(ring(0.6, 0.5), key=lambda row: row.name)
    assert plain == sorted(ring(0.43, 0.30), key=lambda row: row.name)


def test_tokens_of_the_first_schema_never_expire(tmp_path):
    create(tmp_path / "old.db", RELEASED[0])
    with closing(sqlite3.connect(tmp_path / "old.db")) as connection:
        connection.execute("INSERT INTO user_token (name, role, hash) VALUES ('phone', 'view', ?)", ("h" * 64,))
        connection.commit()
    with Database.open(tmp_path / "old.db") as database:
        assert [(token.name, token.expires_at, token.good_for) for token in database.tokens()] == [
            ("phone", None, "both")
        ]


def test_rows_of_words_that_every_robot_has_go_with_the_upgrade(tmp_path):
    create(tmp_path / "old.db", RELEASED[0].with_name("0006.sql"))
    with closing(sqlite3.connect(tmp_path / "old.db")) as connection:
        connection.execute("UPDATE verb SET target = 'drive.command', role = 'admin' WHERE word = 'stop'")
        connection.execute(
            "INSERT INTO verb (robot, word, pattern, target) VALUES ('lbr', 'STOP', 'STOP', 'drive.stop')"
        )
        connection.commit()
    with Database.open(tmp_path / "old.db") as database:
        found = database.load("lbr")
    assert found.problems == ()
    assert {row.pattern for row in found.verbs} & (WORDS_OF_EVERY_ROBOT | {"STOP"}) == set()
    assert "/s/{text...}" in {row.pattern for row in found.verbs}
