"""A look at columns of a database, as they stand: without checks, upgrades or waiting. For completion."""

import sqlite3
from contextlib import closing
from pathlib import Path

from lbr.database.statements import select


def rows(path: Path, table: str, *columns: str) -> list[tuple[str, ...]]:
    """Return what stands in some columns, each once; nothing where they cannot be read."""
    try:
        with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True, timeout=0.1)) as database:
            found = database.execute(select(table, columns, columns))
            return list(dict.fromkeys(tuple(str(value or "") for value in row) for row in found))
    except sqlite3.Error:
        return []
