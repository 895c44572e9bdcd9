"""Rows that packages bring: run beside the schema, one robot at a time, and taken only if they are that robot's own.

rows.sql of a package ──► a database in memory, with schema and lbr ──► what is new there ──► robot.db
                            inserts only                                 checked: package and row are named
"""

import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from pathlib import Path

from msgspec import Struct

from lbr.database import constraints
from lbr.database.checks import check
from lbr.database.connection import Connection
from lbr.database.reading import ROBOT, RawRow, RawTables
from lbr.database.rows import RobotRows
from lbr.database.tables import Schema, read_tables
from lbr.errors import RowError
from lbr.messages.rows import short
from lbr.resources import robot_db_sql
from lbr.robot import registry
from lbr.robot.registry import Found

Judge = Callable[[RobotRows], Iterable[str]]
"""Returns what a start would find wrong with a robot's rows."""
READING = frozenset(
    {
        sqlite3.SQLITE_SELECT,
        sqlite3.SQLITE_READ,
        sqlite3.SQLITE_FUNCTION,
        sqlite3.SQLITE_TRANSACTION,
        sqlite3.SQLITE_RECURSIVE,
    }
)


class Brought(Struct, frozen=True):
    """The rows of all robots that packages bring, one after the other, and why others bring none."""

    robots: tuple[RawTables, ...]
    refused: tuple[str, ...]


def every(judge: Judge = lambda _rows: ()) -> Brought:
    """Return the rows of all robots that packages bring; one that is refused is named, and keeps out no other."""
    robots, refused = [], []
    for installed in registry.every():
        if installed.robot is None:
            refused.append(installed.fault)
        elif installed.robot.rows is not None:
            try:
                robots.append(rows_of(installed, judge))
            except RowError as err:
                refused += err.problems
    return Brought(tuple(robots), tuple(refused))


def rows_of(installed: Found, judge: Judge = lambda _rows: ()) -> RawTables:
    """Return the rows that a package brings for its robot; RowError names package and row of everything wrong."""
    label = f"robot '{installed.name}' of package '{installed.package}'"
    if installed.robot is None or installed.robot.rows is None:
        raise RowError((installed.fault or f"{label} brings no rows",))
    path = installed.robot.rows
    with closing(sqlite3.connect(":memory:", factory=Connection, isolation_level=None)) as connection:
        connection.executescript(robot_db_sql().read_text(encoding="utf-8"))
        before, schema = read_tables(connection)
        try:
            _run(connection, schema, path)
        except ValueError as err:
            raise RowError((f"{label}, {path.name}, {err}",)) from err
        after, _ = read_tables(connection)
    faults = tuple(_faults(installed.name, before, after, schema))
    if not faults:
        rows = check(after, installed.name, columns=schema)
        faults = tuple(map(str, rows.problems)) or tuple(judge(rows))
    if faults:
        raise RowError(tuple(f"{label}: {fault}" for fault in faults))
    return {table: _added(table, before, after, schema) for table in schema}


def _run(connection: Connection, schema: Schema, path: Path) -> None:
    """Run a file of SQL that inserts rows and does nothing else; ValueError says in which line it does not."""

    def allow(action: int, first: str | None, _second: str | None, _where: str | None, trigger: str | None) -> int:
        mine = action == sqlite3.SQLITE_INSERT and (trigger is not None or first in schema)
        switch = action == sqlite3.SQLITE_PRAGMA and first == "foreign_keys"
        return sqlite3.SQLITE_OK if mine or switch or action in READING else sqlite3.SQLITE_DENY

    try:
        script = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as err:
        raise ValueError(f"which cannot be read as text: {err}") from err
    connection.set_authorizer(allow)
    try:
        for line, statement in constraints.statements(script):
            try:
                connection.execute(statement)
            except sqlite3.Error as err:
                denied = "it may insert rows of its robot, and do nothing else"
                why = denied if "not authorized" in str(err) else constraints.words(str(err), statement)
                raise ValueError(f"line {line}: {why}") from err
    finally:
        connection.set_authorizer(None)


def _faults(name: str, before: RawTables, after: RawTables, schema: Schema) -> Iterator[str]:
    """Yield a fault for each row of another robot that a package adds or changes."""
    for table in schema:
        known, now = (_by_key(table, rows, schema) for rows in (before, after))
        for key, row in known.items():
            if now.get(key) != row:
                yield f"{table} '{_row_name(key)}' is not of this robot, and may not be changed"
        for key, row in now.items():
            owner = row["name"] if table == ROBOT else row.get("robot", name)
            if key not in known and owner != name:
                yield f"{table} '{_row_name(key)}' is of robot '{short(owner)}': a package brings rows of its own robot"
    if name not in {row["name"] for row in after[ROBOT]}:
        yield "there is no row of it in the table 'robot'"


def _added(table: str, before: RawTables, after: RawTables, schema: Schema) -> list[RawRow]:
    known = _by_key(table, before, schema)
    return [row for key, row in _by_key(table, after, schema).items() if key not in known]


def _by_key(table: str, rows: RawTables, schema: Schema) -> dict[tuple[object, ...], RawRow]:
    return {tuple(row[name] for name in schema.keys_of[table]): row for row in rows[table]}


def _row_name(key: tuple[object, ...]) -> str:
    return "/".join(map(short, key))
