"""The rows of lbr and of packages, and those of a robot that a database lacks."""

import sqlite3
from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from lbr.database import changes, packaged
from lbr.database.changes import Change
from lbr.database.connection import Connection
from lbr.database.difference import Difference
from lbr.database.packaged import Judge
from lbr.database.proposals import propose
from lbr.database.reading import ROBOT, RawRow, RawTables
from lbr.database.store import Database
from lbr.database.tables import Schema, read_tables
from lbr.errors import InputError
from lbr.resources import robot_db_sql
from lbr.robot import registry


def shipped(sql: Path | None = None) -> tuple[RawTables, Schema]:
    """Return the rows of a new database, or of one that only `sql` builds, and their columns."""
    with closing(sqlite3.connect(":memory:", factory=Connection)) as connection:
        connection.executescript((sql or robot_db_sql()).read_text(encoding="utf-8"))
        rows, schema = read_tables(connection)
    brought = packaged.every().robots if sql is None else ()
    return {
        table: [*of_table, *(row for one in brought for row in one[table])] for table, of_table in rows.items()
    }, schema


def differences(database: Database, sql: Path | None = None) -> tuple[Difference, ...]:
    """Compare a database's rows with those of a new one, or of `sql` alone, table by table; a missing robot is one
    difference."""
    (before, _), (present, schema) = shipped(sql), database.tables()
    robots = {row["name"] for row in present[ROBOT]}
    before = {
        table: [row for row in rows if table == ROBOT or row.get("robot") is None or row["robot"] in robots]
        for table, rows in before.items()
    }
    return changes.differences(changes.between(before, present, schema))


def add(database: Database, robot: str, judge: Judge = lambda _rows: ()) -> dict[str, int]:
    """Add a robot's rows with missing keys; return their number by table. Others stay as they are.

    InputError lists the robots; RowError has the objections of `judge` or the tables to the rows of a package.
    """
    installed = registry.find(robot)
    if installed is None:
        raise InputError(f"no package here brings a robot '{robot}': {', '.join(registry.names())} are there")
    if installed.robot is not None and installed.robot.rows is None:
        rows, _ = shipped(robot_db_sql())
        rows = {table: [row for row in of_table if _is_of(table, row, robot)] for table, of_table in rows.items()}
    else:
        rows = packaged.rows_of(installed, judge)

    def wanted(tables: RawTables, schema: Schema) -> tuple[Change, ...]:
        return tuple(
            Change(table, tuple(row[name] for name in key), None, row)
            for table, key in schema.keys_of.items()
            for row in _missing(key, rows.get(table, ()), tables.get(table, ()))
        )

    added = propose(database, wanted, lambda _rows: ()).changes
    return dict(Counter(change.table for change in added))


def _missing(key: tuple[str, ...], rows: Sequence[RawRow], here: Sequence[RawRow]) -> list[RawRow]:
    known = {_key(key, row) for row in here}
    return [row for row in rows if _key(key, row) not in known]


def _key(key: tuple[str, ...], row: RawRow) -> tuple[object, ...]:
    """Return the identity of a row; the steps of one motion or dance belong together, and are not mixed."""
    return tuple(row[column] for column in key if column != "step")


def _is_of(table: str, row: RawRow, robot: str) -> bool:
    """Return whether a row belongs to a robot; shared rows, such as phrases, are in every new database already."""
    return row["name"] == robot if table == ROBOT else row.get("robot") == robot
