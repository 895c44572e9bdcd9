"""Tables, triggers, indexes and views in a database that are not of lbr's schema."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from lbr.database.connection import Connection
from lbr.messages.rows import shown
from lbr.resources import robot_db_sql

_OBJECTS = (
    "SELECT type, name, tbl_name FROM sqlite_schema WHERE name NOT LIKE 'sqlite!_%' ESCAPE '!' ORDER BY type, name"
)


def foreign(connection: Connection, sql: Path | None = None) -> Iterator[str]:
    """Yield a sentence for each; a trigger can change rows behind an edit."""
    with closing(sqlite3.connect(":memory:")) as ours:
        ours.executescript((sql or robot_db_sql()).read_text(encoding="utf-8"))
        known = {(kind, name) for kind, name, _ in ours.execute(_OBJECTS)}
    for kind, name, table in connection.execute(_OBJECTS):
        if (kind, name) not in known:
            where = (
                f" on the table '{shown(table)}', which acts by itself at each edit there," if kind == "trigger" else ""
            )
            yield f"{kind} '{shown(name)}'{where} is not of lbr's schema: unless it is yours, `DROP {kind.upper()} {shown(name)}`"
