"""One connection to a database file, and SQLite's errors as sentences."""

import os
import re
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal
from urllib.parse import quote

from sqlalchemy import Connection, create_engine, event
from sqlalchemy.exc import DBAPIError
from sqlalchemy.pool import NullPool

from lbr.database import constraints
from lbr.database.files import check_owner, check_owners, check_side_files
from lbr.errors import RowError

BUSY_TIMEOUT_S = 2.0

_RESTORE = "`lbr db restore` puts the last good copy in its place"
_SENTENCES = {
    sqlite3.SQLITE_BUSY: "is locked by another program: close its transaction",
    sqlite3.SQLITE_LOCKED: "is locked by another program: close its transaction",
    sqlite3.SQLITE_READONLY: "is read-only: make the file and its folder writable for you",
    sqlite3.SQLITE_IOERR: "cannot be read or written: check the disk",
    sqlite3.SQLITE_CORRUPT: f"is damaged: {_RESTORE}",
    sqlite3.SQLITE_FULL: "cannot grow, because the disk is full: make room",
    sqlite3.SQLITE_CANTOPEN: "cannot be opened: check that it and its folder exist and are yours",
    sqlite3.SQLITE_INTERRUPT: "has rows that take too long to read or write: a trigger or view that is not of lbr's schema "
    "may be why, and `lbr db check` names those",
    sqlite3.SQLITE_NOTADB: f"is no database at all: name another file; {_RESTORE}",
}
_ROW_FAULT = re.compile(r"CHECK constraint failed in |\S+ value in ")


def connect(path: Path, *, changing: bool = True) -> Connection:
    """Open an existing file; transactions begin as the option `begin` says.

    Without `changing` it is only read, and must be one that nobody changes meanwhile, without a log beside it. RowError
    says which file or folder others could change; what SQLite opened beside the database is looked at once more.
    """
    (check_owners if changing else check_owner)(path)
    mode = "mode=rw" if changing else "mode=ro&immutable=1"
    engine = create_engine("sqlite://", creator=lambda: _connect(path, mode), poolclass=NullPool)
    event.listen(engine, "begin", _begin)
    connection = engine.connect()
    try:
        if changing:
            run(connection, "SELECT count(*) FROM sqlite_schema")  # opens the log
            check_side_files(path)
    except BaseException:
        connection.close()
        raise
    return connection


def pragma(connection: Connection, text: str) -> Any:
    """Run a pragma without beginning a transaction and return its first value."""
    return run(connection, f"PRAGMA {text}")


def run(connection: Connection, statement: str, *values: str) -> Any:
    """Run a statement without beginning a transaction and return its first value."""
    cursor = connection.connection.cursor()
    try:
        cursor.execute(statement, values)
        row = cursor.fetchone()
    finally:
        cursor.close()
    return row[0] if row else None


def damage(connection: Connection) -> str:
    """Return what is broken in the file, or nothing; rows against the schema are for the checks to name."""
    found = connection.connection.cursor().execute("PRAGMA integrity_check").fetchall()
    return next((fault for (fault,) in found if fault != "ok" and not _ROW_FAULT.match(fault)), "")


@contextmanager
def transaction(connection: Connection, mode: Literal["DEFERRED", "IMMEDIATE"]) -> Iterator[Connection]:
    """Commit at the end, or roll back."""
    connection.execution_options(begin=mode)
    with connection.begin():
        yield connection


def flush_log(path: Path) -> None:
    """Bring what was committed onto the disk: SQLite's own way of doing so holds the write lock meanwhile."""
    try:
        with open(f"{os.path.realpath(path)}-wal", "rb") as log:  # noqa: PTH123 - as SQLite names it
            os.fsync(log.fileno())
    except OSError as err:
        raise RowError((f"database {path} cannot be brought onto the disk: {err.strerror}",)) from err


@contextmanager
def sentences(path: Path) -> Iterator[None]:
    """Turn SQLite's errors into RowErrors that say what to do."""
    try:
        yield
    except DBAPIError as err:
        raise RowError((_sentence(path, err.orig, err.statement or ""),)) from err
    except sqlite3.Error as err:
        raise RowError((_sentence(path, err),)) from err
    except UnicodeDecodeError as err:  # SQLite's message quotes a damaged schema
        raise RowError((f"database {path} {_SENTENCES[sqlite3.SQLITE_CORRUPT]}",)) from err


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    connection = sqlite3.connect(
        f"file:{quote(str(path.absolute()))}?{mode}",
        uri=True,
        timeout=BUSY_TIMEOUT_S,
        isolation_level=None,
        check_same_thread=False,
    )
    connection.text_factory = _text
    return connection


def _text(raw: bytes) -> str:
    """Decode without raising, so that the checks can name the row."""
    return raw.decode(errors="surrogateescape")


def _begin(connection: Connection) -> None:
    connection.exec_driver_sql(f"BEGIN {connection.get_execution_options().get('begin', 'DEFERRED')}")


def _sentence(path: Path, error: BaseException | None, statement: str = "") -> str:
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF
    if code == sqlite3.SQLITE_IOERR and _full(path):
        code = sqlite3.SQLITE_FULL
    if code == sqlite3.SQLITE_ERROR:
        shown = "".join(c if c.isprintable() else "?" for c in str(error)[:100])
        return f"database {path} has not the schema it should have ({shown}): {_RESTORE}"
    if code == sqlite3.SQLITE_CONSTRAINT:
        return f"database {path} refuses the row: {constraints.words(str(error), statement)}"
    return f"database {path} {_SENTENCES.get(code, f'refuses: {error}')}"


def _full(path: Path) -> bool:
    try:
        return os.statvfs(path.absolute().parent).f_bavail == 0
    except OSError:
        return False
