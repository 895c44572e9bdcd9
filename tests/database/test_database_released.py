"""Every schema that was ever released becomes today's, and loses nothing."""

import re
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from lbr.database.store import Database, create
from lbr.database.tables import KEYS

RELEASED = sorted((Path(__file__).parent / "released").glob("*.sql"))
STRUCTURE = "SELECT type, name, tbl_name FROM sqlite_schema WHERE name NOT LIKE 'sqlite%' ORDER BY 1, 2"
COLUMNS = "SELECT t.name, c.* FROM pragma_table_list AS t, pragma_table_info(t.name) AS c WHERE t.schema = 'main'"
TRIGGERS = "SELECT name, sql FROM sqlite_schema WHERE type = 'trigger' ORDER BY name"


def shape(path: Path) -> list[object]:
    """Tables, columns and triggers, without comments and white space."""
    with closing(sqlite3.connect(path)) as connection:
        triggers = [(name, " ".join(re.sub(r"--.*", "", sql).split())) for name, sql in connection.execute(TRIGGERS)]
        return [connection.execute(STRUCTURE).fetchall(), sorted(connection.execute(COLUMNS).fetchall()), triggers]


def rows(connection: sqlite3.Connection) -> dict[str, list[object]]:
    """Every row of the tables that make robots, column by column."""
    there = {name for (name,) in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")}
    return {
        table: sorted(connection.execute(f"SELECT * FROM {table}").fetchall(), key=repr)
        for table in KEYS
        if table in there
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
        before = rows(connection)
    with Database.open(tmp_path / "old.db") as database:
        assert database.revisions() == ()
    with closing(sqlite3.connect(tmp_path / "old.db")) as connection:
        after = rows(connection)
        assert {table: after[table] for table in before} == before
        assert not any(after[table] for table in after.keys() - before.keys())


def test_tokens_of_the_first_schema_never_expire(tmp_path):
    create(tmp_path / "old.db", RELEASED[0])
    with closing(sqlite3.connect(tmp_path / "old.db")) as connection:
        connection.execute("INSERT INTO user_token (name, role, hash) VALUES ('phone', 'view', ?)", ("h" * 64,))
        connection.commit()
    with Database.open(tmp_path / "old.db") as database:
        assert [(token.name, token.expires_at) for token in database.tokens()] == [("phone", None)]
