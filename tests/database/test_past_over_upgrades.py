"""Going back over an upgrade of lbr's schema: bridged where columns have defaults, else refused in words."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from lbr.database import changes
from lbr.database.proposals import Proposed, command
from lbr.database.store import Database, create
from lbr.errors import InputError


def edited(path: Path, *statements: str) -> None:
    """Make a database, and edit its rows by another client."""
    create(path)
    with closing(sqlite3.connect(path, isolation_level=None)) as client:
        client.execute("PRAGMA foreign_keys = ON")
        for statement in statements:
            client.execute(statement)


def back(database: Database, number: int) -> Proposed:
    return command(
        database,
        lambda tables, schema: changes.between(tables, database.tables_at(number), schema),
        lambda _rows: (),
        text="went back",
    )


def test_edits_made_before_an_upgrade_are_taken_back_after_it(tmp_path):
    path = tmp_path / "old.db"
    edited(
        path,
        "UPDATE capability SET help = 'mine' WHERE name = 'drive'",
        "DELETE FROM channel WHERE target = 'drive.motors'",
        "UPDATE robot SET owner = 'me' WHERE name = 'lbr'",
        "UPDATE revision SET old_row = json_remove(old_row, '$.process'), new_row = json_remove(new_row, '$.process')",
    )
    with Database.open(path) as database:
        tables, _ = database.tables()
        newest = max(change.last for change in database.changes() if change.rows[-1].table == "robot")
        back(database, 0)
        after, _ = database.tables()
        assert next(row["help"] for row in after["capability"] if row["name"] == "drive") != "mine"
        assert any(row["target"] == "drive.motors" for row in after["channel"])
        assert next(row["owner"] for row in after["robot"] if row["name"] == "lbr") == ""
        back(database, newest)
        assert changes.between(tables, database.tables()[0], database.tables()[1]) == ()


def test_a_row_of_a_table_that_an_upgrade_took_away_is_in_the_way(tmp_path):
    path = tmp_path / "old.db"
    edited(path)
    with closing(sqlite3.connect(path, isolation_level=None)) as client:
        client.execute(
            "INSERT INTO revision (table_name, row_key, operation, new_row) VALUES ('gone', '[\"a\"]', 'insert', '{}')"
        )
    with Database.open(path) as database, pytest.raises(InputError, match="there is no table 'gone' any more"):
        back(database, 0)
