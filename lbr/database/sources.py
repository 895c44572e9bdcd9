"""The wanted rows from a file or folder: SQL that edits rows, a copy of a database, or an export.

SQL runs on a copy in memory, and may only change rows that make robots.
"""

import sqlite3
import stat
import tempfile
import time
from contextlib import closing
from pathlib import Path

from lbr.database import changes, constraints, copies, given_files, row_files
from lbr.database.connection import LONGEST_BYTES, Connection, connect, pragma, sentences
from lbr.database.identity import MAGIC
from lbr.database.packaged import READING
from lbr.database.proposals import Wanted
from lbr.database.reading import RawTables
from lbr.database.store import Database
from lbr.database.tables import Schema, read_tables
from lbr.errors import InputError, RowError

COMPUTED_S = 5.0
"""Of the processor, for one file of SQL."""
STATEMENT_S = 0.5
"""Of it, for one statement: the longest edit of a robot's rows takes a hundredth of that."""
LOOK_EVERY = 10_000
MOST_BYTES = 32_000_000
_CHANGING = {sqlite3.SQLITE_INSERT, sqlite3.SQLITE_UPDATE, sqlite3.SQLITE_DELETE}
_SCRIPT = "it may insert, update and delete rows that make robots, and do nothing else"


def wanted(source: Path, database: Path, robot: str | None = None) -> Wanted:
    """Return a function for the changes of a database to the rows of a source, or only of one robot.

    InputError: there is no such source. RowError names file, line, row and column of a faulty one.
    """
    if source.is_dir():
        files = row_files.read(source, robot)
        return lambda tables, schema: changes.between(tables, row_files.applied(files, tables, schema), schema, robot)
    try:
        about = source.stat()
        if not stat.S_ISREG(about.st_mode):  # reading a pipe would block
            raise InputError(f"{source} is no file that could be read to its end: name a regular file")
        size = about.st_size
        with source.open("rb") as opened:
            content = opened.read(MOST_BYTES + 1) if not (begin := opened.read(len(MAGIC))).startswith(MAGIC) else b""
    except OSError as err:
        raise InputError(f"{source} cannot be read ({err.strerror})", "unknown_name") from err
    if begin == MAGIC:
        found, theirs = _of_copy(source)
        return lambda tables, schema: changes.between(tables, _fitting(source, found, theirs, schema), schema, robot)
    if size > MOST_BYTES:
        raise InputError(f"{source} is too large: more than {MOST_BYTES} bytes are no edit of rows")
    script = given_files.sql_text(begin + content, source)
    return lambda tables, schema: changes.between(tables, _run(source, script, database), schema, robot)


def _of_copy(source: Path) -> tuple[RawTables, Schema]:
    """Return the rows of another database, in the schema of this version; the file stays as it is."""
    with tempfile.TemporaryDirectory(prefix="lbr-copy-") as place:
        copy = Path(place) / "robot.db"
        copies.copy_whole(source, copy)
        with Database.open(copy) as opened:
            return opened.tables()


def _fitting(source: Path, tables: RawTables, theirs: Schema, ours: Schema) -> RawTables:
    """Return another database's rows; raise InputError if it has other tables."""
    for table in ours:
        if table not in theirs or set(theirs[table]) != set(ours[table]):
            raise InputError(f"{source} has not the table '{table}' as this database has it: add it there first")
    if more := [table for table in theirs if table not in ours and tables[table]]:
        raise InputError(f"there is no table '{more[0]}' here, and {source} has rows of it: add it first")
    return tables


def _run(source: Path, script: str, database: Path) -> RawTables:
    """Return the tables after SQL on a copy in memory; raise RowError with the line of a forbidden statement."""
    with closing(sqlite3.connect(":memory:", factory=Connection, isolation_level=None)) as copy:
        with sentences(database), closing(connect(database)) as opened:
            opened.backup(copy)
        copy.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LONGEST_BYTES)
        pragma(copy, "foreign_keys = ON")
        schema = Schema(copy)

        def allow(action: int, first: str | None, _second: str | None, _where: str | None, trigger: str | None) -> int:
            mine = action in _CHANGING and (trigger is not None or first in schema)
            switch = action == sqlite3.SQLITE_PRAGMA and first in {"foreign_keys", "busy_timeout", "defer_foreign_keys"}
            return sqlite3.SQLITE_OK if mine or switch or action in READING else sqlite3.SQLITE_DENY

        last = until = time.thread_time() + COMPUTED_S

        def begin() -> None:
            nonlocal until
            until = min(last, time.thread_time() + STATEMENT_S)

        copy.set_progress_handler(lambda: time.thread_time() > until, LOOK_EVERY)
        copy.set_authorizer(allow)
        if fault := constraints.run(copy, script, _SCRIPT, begin):
            raise RowError((f"{source}, {fault}",))
        copy.set_authorizer(None)
        if copy.in_transaction:
            raise RowError((f"{source}: its transaction has no end: add COMMIT;, or is it cut off?",))
        if dangling := copy.execute("PRAGMA foreign_key_check").fetchone():
            raise RowError(
                (f"{source}: a row of {dangling[0]} would refer to a row of {dangling[2]} that is not there",)
            )
        return read_tables(copy)[0]
