"""The rows of another program's SQLite database, or of its dump as SQL: read in memory, and not trusted.

A dump may only make tables and fill them. It has no access to files, and little time.
"""

import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager

from lbr.database import statements
from lbr.errors import InputError
from lbr.messages.rows import short
from lbr.robot.old_data import ForeignTables

MOST_ROWS = 100_000
COMPUTED_S = 5.0
_MOST_PAGES = 16_384
_LOOK_EVERY = 1_000
_MAKING = {
    sqlite3.SQLITE_CREATE_TABLE,
    sqlite3.SQLITE_CREATE_INDEX,
    sqlite3.SQLITE_INSERT,
    sqlite3.SQLITE_SELECT,  # of several rows of values
    sqlite3.SQLITE_TRANSACTION,
    sqlite3.SQLITE_REINDEX,
}
_SCHEMA = {"sqlite_master", "sqlite_schema", "sqlite_sequence"}
"""The reads and writes while a table is made; a dump resets the last of them."""
_OF_SCHEMA = {sqlite3.SQLITE_READ, sqlite3.SQLITE_UPDATE, sqlite3.SQLITE_DELETE}
_FUNCTIONS = {"replace", "char", "unistr", "length", "lower", "upper", "typeof", "date", "datetime", "strftime"}
"""The functions with which dumps write texts of several lines, and tables their checks and defaults."""
_READING = {sqlite3.SQLITE_SELECT, sqlite3.SQLITE_READ}
_PRAGMAS = {"foreign_keys", "encoding", "user_version", "application_id"}


def of_database(content: bytes) -> ForeignTables:
    """Return the rows of every table of a database file; raise InputError if it is unreadable."""
    with _memory("it is no SQLite database that could be read") as connection:
        plain = bytearray(content)
        plain[18:20] = b"\1\1"  # SQLite could not read one with a write-ahead log in memory; the log is another file
        connection.deserialize(bytes(plain))
        return _tables(connection)


def of_sql(text: str) -> ForeignTables:
    """Return the rows of every table that a dump makes; raise InputError with the refused statement."""
    if "\0" in text:
        raise InputError("it is no SQL that could be read: it has a NUL character in it")
    with _memory("it is no SQL that could be read") as connection:
        connection.set_authorizer(_Making())
        connection.executescript(text)
        return _tables(connection)


class _Making:
    """Permits to make and fill tables, but not from one another, so that the result is no larger than the dump."""

    def __init__(self) -> None:
        self._selects = False

    def __call__(self, action: int, first: str | None, second: str | None, *_: str | None) -> int:
        """Return SQLite's permission; a statement begins with the table that it makes or fills."""
        self._selects = action == sqlite3.SQLITE_SELECT or (self._selects and action != sqlite3.SQLITE_INSERT)
        allowed = (
            action in _MAKING
            or (action in _OF_SCHEMA and first in _SCHEMA)
            or (action == sqlite3.SQLITE_READ and not self._selects)  # a key, to see whether it exists already
            or (action == sqlite3.SQLITE_PRAGMA and first in _PRAGMAS)
            or (action == sqlite3.SQLITE_FUNCTION and second in _FUNCTIONS)
        )
        return sqlite3.SQLITE_OK if allowed else sqlite3.SQLITE_DENY


def _reading(action: int, *_: str | None) -> int:
    return sqlite3.SQLITE_OK if action in _READING else sqlite3.SQLITE_DENY


@contextmanager
def _memory(failed: str) -> Iterator[sqlite3.Connection]:
    until = time.thread_time() + COMPUTED_S
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
        connection.text_factory = lambda raw: raw.decode(errors="replace")
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.execute(f"PRAGMA max_page_count = {_MOST_PAGES}")
        connection.setlimit(sqlite3.SQLITE_LIMIT_ATTACHED, 0)
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, 1 << 20)
        connection.set_progress_handler(lambda: time.thread_time() > until, _LOOK_EVERY)
        try:
            yield connection
        except InputError:
            raise
        except (sqlite3.Error, ValueError, OverflowError, MemoryError) as err:
            raise InputError(f"{failed}: {short(err)}") from err


def _tables(connection: sqlite3.Connection) -> ForeignTables:
    connection.set_authorizer(_reading)
    made = connection.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table'").fetchall()
    names = [name for name, sql in made if not str(sql).upper().startswith("CREATE VIRTUAL")]
    tables: dict[str, list[dict[str, object]]] = {}
    room = MOST_ROWS
    for name in names:
        if name.startswith("sqlite_"):
            continue
        cursor = connection.execute(f"{statements.select(name)} LIMIT ?", (room + 1,))
        columns = [column[0] for column in cursor.description]
        rows = cursor.fetchall()
        room -= len(rows)
        if room < 0:
            raise InputError(f"it has more than {MOST_ROWS} rows, which is no robot's database")
        tables[name] = [dict(zip(columns, row, strict=True)) for row in rows]
    return tables
