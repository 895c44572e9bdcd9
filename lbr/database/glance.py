"""A quick read of columns for completion, with no checks, upgrades or waits."""

import sqlite3
from contextlib import closing
from pathlib import Path

from lbr.database.statements import select


def rows(path: Path, table: str, *columns: str) -> list[tuple[str, ...]]:
    """Return the values of some columns, each once; empty if they are unreadable."""
    try:
        with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True, timeout=0.1)) as database:
            found = database.execute(select(table, columns, columns))
            return list(dict.fromkeys(tuple(str(value or "") for value in row) for row in found))
    except sqlite3.Error:
        return []
