"""A look at one column of a database, as it stands: without checks, upgrades or waiting. For completion."""

import sqlite3
from contextlib import closing
from pathlib import Path


def column(path: Path, table: str, name: str, text: str = "") -> list[tuple[str, str]]:
    """Return the values of a column with what another says of them; nothing where they cannot be read."""
    told = text or "''"
    try:
        with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True, timeout=0.1)) as rows:
            query = f"SELECT DISTINCT {name}, {told} FROM {table} ORDER BY 1"  # noqa: S608 - names of our own
            return [(str(value), str(about or "")) for value, about in rows.execute(query)]
    except sqlite3.Error:
        return []
