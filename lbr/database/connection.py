"""A connection to a database file, with SQLite's errors as sentences."""

import os
import re
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Literal
from urllib.parse import quote

from lbr import disk
from lbr.database import constraints, statements
from lbr.database.files import check_owner, check_owners, check_side_files
from lbr.errors import RowError

BUSY_TIMEOUT_S = 2.0
LONGEST_BYTES = 4_000_000
"""The longest row and the longest value: those that make robots have a few kB. Longer ones cost memory, and delay a
stop."""

_RESTORE = "`lbr db restore` puts the last good copy in its place"
_SENTENCES = {
    sqlite3.SQLITE_BUSY: "is locked by another program: close its transaction",
    sqlite3.SQLITE_LOCKED: "is locked by another program: close its transaction",
    sqlite3.SQLITE_READONLY: "is read-only: make the file and its folder writable for you",
    sqlite3.SQLITE_IOERR: "cannot be read or written: check the disk",
    sqlite3.SQLITE_CORRUPT: f"is damaged: {_RESTORE}",
    sqlite3.SQLITE_FULL: "cannot grow, because the disk is full: make room",
    sqlite3.SQLITE_CANTOPEN: "cannot be opened: check that it and its folder exist and are yours",
    sqlite3.SQLITE_INTERRUPT: "has rows that take too long to read or write: a trigger or view that is not of lbr's "
    "schema may be why, and `lbr db check` names those",
    sqlite3.SQLITE_NOTADB: f"is no database at all: name another file; {_RESTORE}",
}
_TABLE = re.compile(r"(?:FROM|INTO|UPDATE) \"?(\w+)", re.IGNORECASE)
_ROW_FAULT = re.compile(r"CHECK constraint failed in |\S+ value in ")


class Connection(sqlite3.Connection):
    """A connection whose errors carry their statement."""

    def execute(self, sql: str, values: Any = ()) -> sqlite3.Cursor:
        """Run a statement."""
        with knowing(sql):
            return super().execute(sql, values)

    def executemany(self, sql: str, values: Iterable[Any]) -> sqlite3.Cursor:
        """Run a statement once for each of several values."""
        with knowing(sql):
            return super().executemany(sql, values)

    def scalar(self, sql: str, values: object = ()) -> Any:
        """Run a statement and return the first value of its first row, or None."""
        row = self.execute(sql, values).fetchone()
        return row[0] if row else None


def connect(path: Path, *, changing: bool = True) -> Connection:
    """Open an existing file, without a transaction until `transaction` begins one.

    Without `changing`, it is only read; it must not change meanwhile, nor have a log beside it. RowError names a file
    or folder that others could change; the files that SQLite opens beside the database are checked again.
    """
    (check_owners if changing else check_owner)(path)
    mode = "mode=rw" if changing else "mode=ro&immutable=1"
    connection = _connect(path, mode)
    with ExitStack() as failed:
        failed.callback(connection.close)
        if changing:
            connection.scalar("SELECT count(*) FROM sqlite_schema")  # opens the log
            check_side_files(path)
        failed.pop_all()
    return connection


def pragma(connection: Connection, text: str) -> Any:
    """Run a pragma and return its first value."""
    return connection.scalar(f"PRAGMA {text}")


def damage(connection: Connection) -> str:
    """Return the damage of the file, or an empty text; the checks report rows against the schema."""
    found = connection.execute("PRAGMA integrity_check").fetchall()
    return next((fault for (fault,) in found if fault != "ok" and not _ROW_FAULT.match(fault)), "")


def selected(connection: Connection, table: str, where: str, *values: object) -> list[dict[str, Any]]:
    """Return the rows of one of lbr's own tables."""
    found = connection.execute(f"{statements.select(table)} WHERE {where}", values)
    names = [column[0] for column in found.description]
    return [dict(zip(names, row, strict=True)) for row in found]


def insert(connection: Connection, table: str, rows: Sequence[Mapping[str, object]], more: str = "") -> None:
    """Write rows of the same columns; `more` is what follows the values, such as ON CONFLICT."""
    if rows:
        statement = f"{statements.insert(table, rows[0])} {more}"
        connection.executemany(statement, [tuple(row.values()) for row in rows])


@contextmanager
def transaction(connection: Connection, mode: Literal["DEFERRED", "IMMEDIATE"]) -> Iterator[Connection]:
    """Commit at the end, or roll back."""
    connection.execute(f"BEGIN {mode}")
    try:
        yield connection
        connection.execute("COMMIT")
    finally:
        if connection.in_transaction:  # SQLite itself rolls back a transaction after a full disk
            connection.execute("ROLLBACK")


def flush_log(path: Path) -> None:
    """Write the committed changes to the disk: SQLite itself would hold the write lock meanwhile."""
    try:
        disk.sync(Path(f"{os.path.realpath(path)}-wal"))  # as SQLite names it
    except OSError as err:
        raise RowError((f"database {path} cannot be brought onto the disk: {err.strerror}",)) from err


def vacuum_into(connection: Connection, target: Path) -> None:
    """Write a complete copy to the disk: a new file, readable only by its owner, which is removed on a failure."""
    with disk.created(target):
        connection.execute("VACUUM INTO ?", (str(target),))
        disk.sync(target)


def settle(connection: Connection) -> None:
    """Move all commits into the file itself, so that it can be renamed; raises without room for it."""
    pragma(connection, "wal_checkpoint(TRUNCATE)")


@contextmanager
def sentences(path: Path) -> Iterator[None]:
    """Turn SQLite's errors into RowErrors with the cure."""
    try:
        yield
    except sqlite3.Error as err:
        raise RowError((_sentence(path, err, getattr(err, "statement", "")),)) from err
    except UnicodeDecodeError as err:  # SQLite's message quotes a damaged schema
        raise RowError((f"database {path} {_SENTENCES[sqlite3.SQLITE_CORRUPT]}",)) from err


@contextmanager
def knowing(statement: str) -> Iterator[None]:
    """Add the statement to an error."""
    try:
        yield
    except sqlite3.Error as err:
        err.statement = statement  # type: ignore[attr-defined]
        raise


def _connect(path: Path, mode: str) -> Connection:
    connection = sqlite3.connect(
        f"file:{quote(str(path.absolute()))}?{mode}",
        uri=True,
        timeout=BUSY_TIMEOUT_S,
        isolation_level=None,
        check_same_thread=False,
        factory=Connection,
    )
    connection.text_factory = _text
    return connection


@contextmanager
def short_values(connection: Connection) -> Iterator[None]:
    """Let SQLite refuse values and rows that are longer than those that make robots ever are."""
    before = connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LONGEST_BYTES)
    try:
        yield
    finally:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, before)


def _text(raw: bytes) -> str:
    """Decode without raising, so that the checks can name the row."""
    return raw.decode(errors="surrogateescape")


def _sentence(path: Path, error: sqlite3.Error, statement: str) -> str:
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF
    if code == sqlite3.SQLITE_IOERR and _full(path):
        code = sqlite3.SQLITE_FULL
    if code == sqlite3.SQLITE_ERROR:
        shown = "".join(c if c.isprintable() else "?" for c in str(error)[:100])
        return f"database {path} has not the schema it should have ({shown}): {_RESTORE}"
    if code == sqlite3.SQLITE_TOOBIG:
        where = f" in '{found[1]}'" if (found := _TABLE.search(statement)) else ""
        return (
            f"database {path} has a row{where} of more than {LONGEST_BYTES / 1e6:g} MB, or would get one, and lbr "
            "reads none so long: shorten or delete it with sqlite3, where length(COLUMN) finds it"
        )
    if code == sqlite3.SQLITE_CONSTRAINT:
        return f"database {path} refuses the row: {constraints.words(str(error), statement)}"
    return f"database {path} {_SENTENCES.get(code, f'refuses: {error}')}"


def _full(path: Path) -> bool:
    try:
        return os.statvfs(path.absolute().parent).f_bavail == 0
    except OSError:
        return False
