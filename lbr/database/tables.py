"""Reads the raw tables that make a robot, whatever their content."""

import json
from typing import Any

from lbr.database import statements
from lbr.database.columns import columns
from lbr.database.connection import Connection, knowing, short_values
from lbr.database.reading import RawRow, RawTables
from lbr.database.rows import CORE

WRITTEN_BY_LBR = {(row.TABLE, name) for row in CORE for name, column in columns(row).items() if column.by_lbr}
"""Columns that lbr writes while a robot runs; their changes do not count as edits."""

_COLUMNS = """
SELECT t.name, c.name, c.pk, c."notnull", c.dflt_value FROM sqlite_schema AS t, pragma_table_info(t.name) AS c
WHERE t.type = 'table' AND (
    t.name IN (SELECT value FROM json_each(?))
    OR t.name IN (SELECT tbl_name FROM sqlite_schema WHERE type = 'trigger' AND sql LIKE '%INSERT INTO revision%')
) ORDER BY t.rowid, c.cid
"""


_CORE = json.dumps([row.TABLE for row in CORE])


class Schema(dict[str, tuple[str, ...]]):
    """The columns of each table that makes robots: every robot's tables, and tables whose changes are kept as
    revisions.

    `keys_of` a table identify its rows.
    """

    def __init__(self, connection: Connection) -> None:
        super().__init__()
        self.keys_of: dict[str, tuple[str, ...]] = {}
        self._defaults: dict[tuple[str, str], str | None] = {}
        keys: dict[str, list[tuple[int, str]]] = {}
        for table, column, place, not_null, default in connection.execute(_COLUMNS, (_CORE,)):
            self[table] = (*self.get(table, ()), column)
            keys.setdefault(table, [])
            if default is not None or not not_null:
                self._defaults[table, column] = default
            if place:
                keys[table].append((place, column))
        for table, of_table in keys.items():
            self.keys_of[table] = tuple(name for _, name in sorted(of_table)) or self[table]

    def default(self, table: str, column: str) -> Any:
        """Return the value of a column in a new row that leaves it out; raise LookupError if it is required."""
        text = self._defaults[table, column]
        if text is None or text.upper() == "NULL":
            return None
        if text.startswith("'"):
            return text[1:-1].replace("''", "'")
        try:
            return int(text) if text.lstrip("-").isdigit() else float(text)
        except ValueError:
            raise LookupError(column) from None


def read_tables(connection: Connection) -> tuple[RawTables, Schema]:
    """Return every table's rows in the order of their keys, and their columns."""
    schema = Schema(connection)
    with short_values(connection):
        return {table: _rows(connection, table, schema) for table in schema}, schema


def _rows(connection: Connection, table: str, schema: Schema) -> list[RawRow]:
    statement = statements.select(table, schema[table], schema.keys_of[table])
    with knowing(statement):
        return [dict(zip(schema[table], row, strict=True)) for row in connection.execute(statement)]
