"""A new database for each test, as the first run builds it: built once in a process, and copied."""

import os
import sqlite3
import tempfile
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

from lbr import plugins
from lbr.database import store
from lbr.database.checks import RobotRows, check
from lbr.database.reading import RawTables
from lbr.database.rows import TokenRow
from lbr.database.shipped import shipped
from lbr.database.tables import Schema
from lbr.messages.system import TokenRole


def fresh(path: Path) -> Path:
    """Make a database with the shipped rows; with those of other packages too, while such are installed."""
    if any(not one.ours for one in plugins.every("robots")):
        store.create(path)
        return path
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600), "wb") as file:
        file.write(_built())
    return path


def in_home(home: Path) -> Path:
    """Make the database of a home."""
    return fresh(home / "robot.db")


def edit(path: Path, *statements: str) -> None:
    """Edit rows by another client: by statements, each of which may be several."""
    with closing(sqlite3.connect(path, isolation_level=None)) as client:
        client.execute("PRAGMA foreign_keys = ON")
        for statement in statements:
            client.executescript(statement)


def asked(path: Path, statement: str, *values: object) -> list[tuple[Any, ...]]:
    """Return the answer to a statement of another client."""
    with closing(sqlite3.connect(path, timeout=5.0, isolation_level=None)) as client:
        return client.execute(statement, values).fetchall()


def newest(home: Path) -> int:
    """Return the number of the last change of a home's rows."""
    ((number,),) = asked(home / "robot.db", "SELECT coalesce(max(id), 0) FROM revision")
    return int(number)


def token(name: str, role: TokenRole, kept: str, expires_at: str | None = None, **more: Any) -> TokenRow:
    """The row of a token whose hash is `kept`."""
    return TokenRow(
        name=name, role=role, hash=kept, expires_at=expires_at, **{"created_at": "2026-01-01T00:00:00.000Z", **more}
    )


@cache
def tables() -> tuple[RawTables, Schema]:
    """Return the rows of a new database and their columns, read once in a process: nobody changes them."""
    return shipped()


@cache
def of_robot(robot: str) -> RobotRows:
    """Return the rows of a robot in a new database."""
    raw, columns = tables()
    return check(raw, robot, columns=columns)


@cache
def _built() -> bytes:
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        path = Path(place) / "robot.db"
        store.create(path)
        return path.read_bytes()
