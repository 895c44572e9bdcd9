"""The rows that ship with lbr, and what of a robot's is not in a database yet."""

import sqlite3
from contextlib import closing
from pathlib import Path

from lbr.database.resources import robot_db_sql
from lbr.database.store import Database
from lbr.database.tables import KEYS, TABLES, RawRow, RawTables
from lbr.errors import InputError


def shipped(sql: Path | None = None) -> RawTables:
    """Return the rows of all robots that `sql` (the shipped robot.db.sql) builds."""
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.row_factory = sqlite3.Row
        connection.executescript((sql or robot_db_sql()).read_text(encoding="utf-8"))
        return {
            table.name: [dict(row) for row in connection.execute(f"SELECT * FROM {table.name}")]  # noqa: S608 - ours
            for table in TABLES
        }


def add(database: Database, robot: str, sql: Path | None = None) -> dict[str, int]:
    """Add a robot's shipped rows whose keys are not there; return how many of each table. Others stay as they are."""
    rows = shipped(sql)
    names = sorted(str(row["name"]) for row in rows["robot"])
    if robot not in names:
        raise InputError(f"no robot '{robot}' ships with lbr: {', '.join(names)} do")
    here = database.tables()
    missing = {table: _missing(table, rows, here, robot) for table in KEYS}
    found = {table: rows for table, rows in missing.items() if rows}
    database.add_rows(found)
    return {table: len(rows) for table, rows in found.items()}


def _missing(table: str, rows: RawTables, here: RawTables, robot: str) -> list[RawRow]:
    known = {_key(table, row) for row in here.get(table, ())}
    return [row for row in rows[table] if _is_of(table, row, robot) and _key(table, row) not in known]


def _key(table: str, row: RawRow) -> tuple[object, ...]:
    """Return what makes a row the same; the steps of one motion or dance belong together, and are not mixed."""
    return tuple(row[column] for column in KEYS[table] if column != "step")


def _is_of(table: str, row: RawRow, robot: str) -> bool:
    """Say whether a row is of a robot; phrases are of all of them, so a robot that is added brings none."""
    return row["name"] == robot if table == "robot" else row.get("robot") == robot
