import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from lbr.database.store import Database
from tests.support import databases


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A new database, just as the first run builds it."""
    file = tmp_path / "robot.db"
    databases.fresh(file)
    return file


@pytest.fixture
def database(path: Path) -> Iterator[Database]:
    with Database.open(path) as opened:
        yield opened


@pytest.fixture
def client(path: Path) -> Iterator[sqlite3.Connection]:
    """Somebody else's plain connection to the same file."""
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("PRAGMA foreign_keys = ON")
        yield connection
