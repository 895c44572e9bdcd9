"""Reads the tables that make a robot as they stand, and compares their columns with the models."""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, Table, text

from lbr.database.models import CONFIGURATION
from lbr.database.reader import shown
from lbr.database.rows import Problem

RawRow = Mapping[str, Any]
RawTables = Mapping[str, Sequence[RawRow]]
"""Table name to rows, each column name to what SQLite holds."""

TABLES: tuple[Table, ...] = CONFIGURATION
WRITTEN_BY_LBR = {("robot", name) for name in ("last_start", "last_shutdown", "estop_engaged", "estop_reason")}
"""Columns that lbr writes while a robot runs; their changes are no edits."""
KEYS: dict[str, tuple[str, ...]] = {
    str(table.name): tuple(str(column.name) for column in table.primary_key) for table in TABLES
}
"""The columns of each table's key; plain texts, which JSON takes, unlike SQLAlchemy's own."""

_ROWS = {
    table.name: f"SELECT {', '.join(column.name for column in table.columns)} FROM {table.name}"  # noqa: S608 - our names
    f" ORDER BY {', '.join(KEYS[table.name])}"
    for table in TABLES
}
"""Made once: to have them made anew for each connection takes longer than the reading."""
_COLUMNS = text("SELECT t.name, c.name FROM sqlite_schema AS t, pragma_table_info(t.name) AS c WHERE t.type = 'table'")


def read_tables(connection: Connection) -> tuple[RawTables, tuple[Problem, ...]]:
    """Return every table's rows; a table that lost a column has none, and is named in the problems."""
    columns: dict[str, set[str]] = {}
    for table, column in connection.execute(_COLUMNS):
        columns.setdefault(table, set()).add(column)
    problems: list[Problem] = []
    rows: dict[str, list[RawRow]] = {}
    for table in TABLES:
        if _comparable(table, columns.get(table.name, set()), problems):
            names = [str(column.name) for column in table.columns]
            found = connection.exec_driver_sql(_ROWS[table.name]).all()
            rows[table.name] = [dict(zip(names, row, strict=True)) for row in found]
    return rows, tuple(problems)


def _comparable(table: Table, found: set[str], problems: list[Problem]) -> bool:
    wanted = {column.name for column in table.columns}
    problems.extend(Problem(table.name, "", name, "this column is missing") for name in sorted(wanted - found))
    problems.extend(
        Problem(table.name, "", shown(name), "lbr knows no column of this name: drop it")
        for name in sorted(found - wanted)
    )
    return wanted <= found
