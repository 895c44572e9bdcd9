"""The rows that ship with lbr, and what of a robot's is not in a database yet."""

import sqlite3
from contextlib import closing
from pathlib import Path

from lbr.database.connection import Connection
from lbr.database.reading import RawRow, RawTables
from lbr.database.resources import robot_db_sql
from lbr.database.store import Database
from lbr.database.tables import Schema, read_tables
from lbr.errors import InputError


def shipped(sql: Path | None = None) -> tuple[RawTables, Schema]:
    """Return the rows of all robots that `sql` (the shipped robot.db.sql) builds, and what their columns are."""
    with closing(sqlite3.connect(":memory:", factory=Connection)) as connection:
        connection.executescript((sql or robot_db_sql()).read_text(encoding="utf-8"))
        return read_tables(connection)


def add(database: Database, robot: str, sql: Path | None = None) -> dict[str, int]:
    """Add a robot's shipped rows whose keys are not there; return how many of each table. Others stay as they are."""
    rows, schema = shipped(sql)
    names = sorted(str(row["name"]) for row in rows["robot"])
    if robot not in names:
        raise InputError(f"no robot '{robot}' ships with lbr: {', '.join(names)} do")
    here, _ = database.tables()
    missing = {table: _missing(table, key, rows, here, robot) for table, key in schema.keys_of.items()}
    found = {table: rows for table, rows in missing.items() if rows}
    database.add_rows(found)
    return {table: len(rows) for table, rows in found.items()}


def _missing(table: str, key: tuple[str, ...], rows: RawTables, here: RawTables, robot: str) -> list[RawRow]:
    known = {_key(key, row) for row in here.get(table, ())}
    return [row for row in rows[table] if _is_of(table, row, robot) and _key(key, row) not in known]


def _key(key: tuple[str, ...], row: RawRow) -> tuple[object, ...]:
    """Return what makes a row the same; the steps of one motion or dance belong together, and are not mixed."""
    return tuple(row[column] for column in key if column != "step")


def _is_of(table: str, row: RawRow, robot: str) -> bool:
    """Say whether a row is of a robot; phrases are of all of them, so a robot that is added brings none."""
    return row["name"] == robot if table == "robot" else row.get("robot") == robot
