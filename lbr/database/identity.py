"""The recognition of a robot's database: by its tables. The number in its header is only for file(1), and may be lost
in a backup."""

import re
from pathlib import Path

from lbr.database.connection import Connection, damage, pragma
from lbr.messages.rows import short

MAGIC = b"SQLite format 3\0"
APPLICATION_ID = 0x4C425231
_TABLES = ("alembic_version", "robot", "capability")
_MAKING = tuple(re.compile(rf'CREATE TABLE (IF NOT EXISTS )?"?{name}"?\s*\('.encode()) for name in _TABLES)


def is_robots(connection: Connection) -> bool:
    """Return whether a database has the tables of every robot's."""
    count = "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name IN (?, ?, ?)"
    return bool(connection.scalar(count, _TABLES) == len(_TABLES))


def fault(connection: Connection) -> str:
    """Return why a file is not a good database of a robot, or an empty text."""
    if not is_robots(connection):
        return "is not a robot's database"
    return f"is damaged ({short(broken)})" if (broken := damage(connection)) else ""


def number(connection: Connection) -> None:
    """Set the number in the header, which a backup may have lost."""
    if pragma(connection, "application_id") != APPLICATION_ID:
        pragma(connection, f"application_id = {APPLICATION_ID}")


def as_sql(path: Path, content: bytes) -> str:
    """Return how to restore a robot's database from SQL; empty for other SQL."""
    return "" if content.startswith(MAGIC) else own(path, content)


def own(path: Path, content: bytes) -> str:
    """Return how to restore a robot's database from a file, a database or SQL; empty for other files."""
    if not all(making.search(content) for making in _MAKING):
        return ""
    if content.startswith(MAGIC):
        return "it is a database of this lbr: 'lbr db restore' puts one in the place of robot.db"
    return f"it is a robot's database as SQL: 'lbr db init --sql {path} --db NEW.db' builds one of it"
