"""Rows of packages: run beside the schema, one robot at a time, and accepted only if they belong to that robot.

rows.sql of a package ──► a database in memory, with schema and lbr ──► what is new there ──► robot.db
                            inserts only                                 checked: package and row are named
"""

import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from pathlib import Path

from msgspec import Struct

from lbr.database import changes, constraints
from lbr.database.changes import Change
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
"""Returns the problems that a start would find in a robot's rows."""
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
    """The rows of the robots of all packages, in order, and the reasons for refused ones."""

    robots: tuple[RawTables, ...]
    refused: tuple[str, ...]


def every(judge: Judge = lambda _rows: ()) -> Brought:
    """Return the rows of the robots of all packages; a refused one is named, and does not affect the others."""
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
    """Return a package's rows for its robot; raise RowError with package and row of every fault."""
    label = f"robot '{installed.name}' of package '{installed.package}'"
    if installed.robot is None or installed.robot.rows is None:
        raise RowError((installed.fault or f"{label} brings no rows",))
    path = installed.robot.rows
    with closing(sqlite3.connect(":memory:", factory=Connection, isolation_level=None)) as connection:
        connection.executescript(robot_db_sql().read_text(encoding="utf-8"))
        before, schema = read_tables(connection)
        if fault := _run(connection, schema, path):
            raise RowError((f"{label}, {path.name}, {fault}",))
        after, _ = read_tables(connection)
    made = changes.between(before, after, schema)
    faults = tuple(_faults(installed.name, made))
    if not faults:
        rows = check(after, installed.name, columns=schema)
        faults = tuple(map(str, rows.problems)) or tuple(judge(rows))
    if faults:
        raise RowError(tuple(f"{label}: {fault}" for fault in faults))
    added: dict[str, list[RawRow]] = {table: [] for table in schema}
    for change in made:
        added[change.table].append(change.after or {})
    return added


def _run(connection: Connection, schema: Schema, path: Path) -> str:
    """Run a file of SQL that only inserts rows; return its fault, such as the line of any other statement."""

    def allow(action: int, first: str | None, _second: str | None, _where: str | None, trigger: str | None) -> int:
        mine = action == sqlite3.SQLITE_INSERT and (trigger is not None or first in schema)
        switch = action == sqlite3.SQLITE_PRAGMA and first == "foreign_keys"
        return sqlite3.SQLITE_OK if mine or switch or action in READING else sqlite3.SQLITE_DENY

    try:
        script = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as err:
        return f"which cannot be read as text: {err}"
    connection.set_authorizer(allow)
    fault = constraints.run(connection, script, "it may insert rows of its robot, and do nothing else")
    connection.set_authorizer(None)
    return fault


def _faults(name: str, made: Iterable[Change]) -> Iterator[str]:
    """Yield a fault for each row of another robot that a package adds or changes."""
    for change in made:
        if change.before is not None:
            yield f"{change.table} '{change.row}' is not of this robot, and may not be changed"
        elif change.robot not in {None, name}:
            text = f"is of robot '{short(change.robot)}': a package brings rows of its own robot"
            yield f"{change.table} '{change.row}' {text}"
    if not any((change.table, change.key) == (ROBOT, (name,)) for change in made):
        yield "there is no row of it in the table 'robot'"
