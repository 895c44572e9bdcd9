"""Going back over an upgrade of lbr's schema: bridged where columns have defaults, else refused in words."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from lbr.database import becoming, past
from lbr.database.store import Database, create
from lbr.errors import InputError

RELEASED = Path(__file__).parent / "released"


def upgraded(path: Path, schema: str, *statements: str) -> None:
    """Make a database of an older lbr, edit its rows there, and leave it for this one."""
    create(path, RELEASED / f"{schema}.sql")
    with closing(sqlite3.connect(path, isolation_level=None)) as client:
        client.execute("PRAGMA foreign_keys = ON")
        for statement in statements:
            client.execute(statement)


def back(database: Database, number: int) -> past.Became:
    return becoming.become(
        database, lambda tables, schema, at: past.steps(tables, at(number), schema), lambda _rows: (), text="went back"
    )


@pytest.mark.parametrize("schema", [path.stem for path in sorted(RELEASED.glob("*.sql"))])
def test_edits_made_before_an_upgrade_are_taken_back_after_it(tmp_path, schema):
    path = tmp_path / "old.db"
    upgraded(
        path,
        schema,
        "UPDATE capability SET help = 'mine' WHERE name = 'drive'",
        "DELETE FROM channel WHERE target = 'drive.motors'",
        "UPDATE robot SET owner = 'me' WHERE name = 'lbr'",
    )
    with Database.open(path) as database:
        assert database.backup is not None
        tables, _ = database.tables()
        before = {(row["robot"], row["name"]): row["help"] for row in tables["capability"]}
        newest = max(change.last for change in database.changes() if change.rows[-1].table == "robot")
        assert database.changes()[0].text == "before lbr kept who it was"
        back(database, 0)
        after, _ = database.tables()
        assert before["lbr", "drive"] == "mine"
        assert next(row["help"] for row in after["capability"] if row["name"] == "drive") != "mine"
        assert any(row["target"] == "drive.motors" for row in after["channel"])
        assert next(row["owner"] for row in after["robot"] if row["name"] == "lbr") == ""
        back(database, newest)
        assert past.steps(tables, database.tables()[0], database.tables()[1]) == ()


def test_a_row_of_a_table_that_an_upgrade_took_away_is_in_the_way(tmp_path):
    path = tmp_path / "old.db"
    upgraded(path, "0007")
    with closing(sqlite3.connect(path, isolation_level=None)) as client:
        client.execute(
            "INSERT INTO revision (table_name, row_key, operation, new_row) VALUES ('gone', '[\"a\"]', 'insert', '{}')"
        )
    with Database.open(path) as database, pytest.raises(InputError, match="there is no table 'gone' any more"):
        back(database, 0)
