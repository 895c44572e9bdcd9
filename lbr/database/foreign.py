"""Tables, triggers, indexes and views in a database that are not of lbr's schema."""

import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from lbr.database.connection import Connection
from lbr.database.tables import Schema
from lbr.database.triggers import revision_triggers
from lbr.messages.rows import short
from lbr.resources import robot_db_sql

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_OBJECTS = (
    "SELECT type, name, tbl_name FROM sqlite_schema WHERE name NOT LIKE 'sqlite!_%' ESCAPE '!' ORDER BY type, name"
)


def foreign(connection: Connection, sql: Path | None = None) -> Iterator[str]:
    """Yield one sentence for each; a trigger can change rows behind an edit."""
    with closing(sqlite3.connect(":memory:")) as ours:
        ours.executescript((sql or robot_db_sql()).read_text(encoding="utf-8"))
        known = {(kind, name) for kind, name, _ in ours.execute(_OBJECTS)}
    schema = Schema(connection)
    for kind, name, table in connection.execute(_OBJECTS):
        if (kind, name) in known:
            continue
        drop = f"unless it is yours, `DROP {kind.upper()} {short(name)}`"
        if kind == "table" and name not in schema and (triggers := _triggers(connection, name)):
            yield (
                f"table '{short(name)}' has not the triggers that keep its changes, so nothing of lbr reads it: {drop};"
                f" if a capability of yours is to read it, these make them:\n\n{triggers}"
            )
            continue
        where = f" on the table '{short(table)}', which acts by itself at each edit there," if kind == "trigger" else ""
        yield f"{kind} '{short(name)}'{where} is not of lbr's schema: {drop}"


def _triggers(connection: Connection, table: str) -> str:
    """Return the SQL of the triggers that a table lacks; empty if its names show that it is not a capability's."""
    found = connection.execute("SELECT name, pk FROM pragma_table_info(?)", (table,)).fetchall()
    columns = [name for name, _ in found]
    key = [name for name, _ in sorted((one for one in found if one[1]), key=lambda one: one[1])]
    plain = all(_NAME.fullmatch(name) for name in (table, *columns))
    return revision_triggers(table, columns, key) if key and plain else ""
