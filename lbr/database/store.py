"""The database file: create it, open it with every check, and the executive's reads and writes."""

import math
import os
import pwd
import sqlite3
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Self

from lbr import disk
from lbr.database import adopted, audit, constraints, foreign, history, identity, packaged, past, statements, tokens
from lbr.database.connection import (
    BUSY_TIMEOUT_S,
    Connection,
    connect,
    flush_log,
    insert,
    pragma,
    sentences,
    settle,
    short_values,
    transaction,
)
from lbr.database.files import check_file, check_folder, log_files
from lbr.database.given_files import sql_text
from lbr.database.migrate import bring_up_to_date
from lbr.database.packaged import Brought, Judge
from lbr.database.reading import RawTables
from lbr.database.rows import AuditRow, RevisionRow, RobotRows, TokenRow
from lbr.database.seen import Seen
from lbr.database.tables import Schema, read_tables
from lbr.errors import InputError, RowError
from lbr.messages.system import Event
from lbr.resources import robot_db_sql

PATIENCE_S = 0.1
COMPUTED_S = 0.5
"""Of the processor, for one transaction of a caller that must not be delayed: fifty times what the shipped rows
take."""
LOOK_EVERY = 10_000
"""Steps of SQLite's virtual machine, some more than the shipped rows take."""


def account() -> str:
    """Return the name of the account that this process runs as."""
    try:
        return pwd.getpwuid(os.getuid()).pw_name
    except KeyError:  # an account without a name
        return f"user {os.getuid()}"


def moment_text(moment: datetime) -> str:
    """Return a time in UTC as rows have it."""
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def create(path: Path, sql: Path | None = None, judge: Judge = lambda _rows: ()) -> tuple[str, ...]:
    """Build a new database from `sql` alone, or from robot.db.sql and the robots of packages.

    Return why robots are left out: the tables or `judge` refuse their packages' rows. InputError if the file exists;
    RowError has the line at which SQLite refuses `sql`.
    """
    if path.exists():
        raise InputError(f"database {path} exists already: name another, or move it away first")
    script = sql or robot_db_sql()
    source = sql_text(script.read_bytes(), script)
    brought = packaged.every(judge) if sql is None else Brought((), ())
    building = path.with_name(f"{path.name}.new-{os.getpid()}")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        check_folder(path)
        building.unlink(missing_ok=True)
        os.close(disk.create(building))
        with sentences(path), closing(sqlite3.connect(building, factory=Connection)) as connection:
            try:
                connection.executescript(source)
            except (sqlite3.IntegrityError, sqlite3.OperationalError) as err:
                if sql is None or not (why := constraints.refused(source)):
                    raise
                raise RowError((f"{sql}, {why}",)) from err
            _take(connection, brought)
            settle(connection)
        path.hardlink_to(building)  # unlike a rename, never over a file that another process built meanwhile
    except OSError as err:
        raise InputError(f"database {path} cannot be built ({err.strerror}): check the folder") from err
    finally:
        for name in (building, *log_files(building)):
            with suppress(OSError):
                name.unlink()
    return brought.refused


def _take(connection: Connection, brought: Brought) -> None:
    """Write the rows of packages into a new database, whose revisions begin afterwards; the first phrase of a name
    counts."""
    with connection:
        for rows in brought.robots:
            for table, of_table in rows.items():
                insert(connection, table, of_table, "ON CONFLICT DO NOTHING")
        if brought.robots:
            connection.execute("DELETE FROM revision")
            connection.execute("DELETE FROM sqlite_sequence WHERE name = 'revision'")


class Database:
    """An open robot database: one connection, safe to use from several threads, short transactions.

    Every method raises RowError with one sentence when the file is locked for too long, full, damaged or gone.
    """

    def __init__(
        self, path: Path, connection: Connection, *, wall_ns: Callable[[], int] = time.time_ns, program: str = "lbr"
    ) -> None:
        self.path = path
        self.program = program
        self.backup: Path | None = None
        self._connection = connection
        self.wall_ns = wall_ns
        self._lock = threading.RLock()
        self._until_cpu_s = math.inf
        self._computed_s = math.inf

    def bound(self, computed_s: float = COMPUTED_S) -> None:
        """Interrupt, from now on, transactions that compute for longer in the calling thread, with a RowError.

        For a caller that must not be delayed by rows, views and triggers in SQLite.
        """
        self._computed_s = computed_s
        self._connection.set_progress_handler(lambda: time.thread_time() > self._until_cpu_s, LOOK_EVERY)

    @classmethod
    def open(cls, path: Path, *, wall_ns: Callable[[], int] = time.time_ns, program: str = "lbr") -> Self:
        """Check a database, back up and upgrade an older one, and open it; raise RowError or InputError with the cure.

        `program` is the author in records of changed rows.
        """
        check_file(path)
        with sentences(path):
            database = cls(path, connect(path), wall_ns=wall_ns, program=program)
            with ExitStack() as failed:
                failed.callback(database.close)
                database._prepare()
                failed.pop_all()
        return database

    def data_version(self) -> int:
        """Return a number that changes when another connection has committed; our own writes leave it."""
        with self._lock, sentences(self.path):
            self._begin()
            pragma(self._connection, f"busy_timeout = {PATIENCE_S * 1000:.0f}")
            return int(pragma(self._connection, "data_version"))

    def robots(self, only: str | None = None) -> tuple[str, ...]:
        """Return the names of all robots in the file, or `only` one of them; raise InputError if it is missing."""
        with self.reading() as connection:
            names = tuple(name for (name,) in connection.execute("SELECT name FROM robot ORDER BY name"))
        if only is None:
            return names
        if only not in names:
            there = ", ".join(names) or "none"
            raise InputError(f"there is no robot '{only}' in {self.path}: {there}", "unknown_name")
        return (only,)

    def load(self, robot: str, *, patience_s: float = BUSY_TIMEOUT_S) -> RobotRows:
        """Read a robot's rows in one transaction; bad rows become problems, only an unreadable file raises RowError."""
        return self.load_all((robot,), patience_s=patience_s)[robot]

    def load_all(self, robots: Iterable[str], *, patience_s: float = BUSY_TIMEOUT_S) -> dict[str, RobotRows]:
        """Read the rows of several robots in one transaction, as `load` does."""
        with self.reading(patience_s) as connection:
            seen = Seen.by(connection)
        return {name: seen.rows(name) for name in robots}

    def tables(self) -> tuple[RawTables, Schema]:
        """Return the raw rows of all robots, unchecked, and their columns."""
        with self.reading() as connection:
            return read_tables(connection)

    def foreign(self) -> tuple[str, ...]:
        """Return one sentence for each table, trigger, index and view that is not of lbr's schema."""
        with self.reading() as connection:
            return tuple(foreign.foreign(connection))

    def append_events(self, events: Iterable[Event], trail: Sequence[AuditRow] = ()) -> None:
        """Write events, and entries of the audit trail, in one transaction; a `wall_ns` of 0 becomes now.

        The oldest are deleted when there are many. With entries, it is on the disk on return. It waits for other
        writers for only a tenth of a second, as all this can be written later.
        """
        with self.writing(durable=bool(trail), patience_s=PATIENCE_S) as connection:
            history.append_events(connection, events, self.wall_ns())
            audit.append(connection, trail)

    def audit(self, limit: int = 100) -> tuple[AuditRow, ...]:
        """Return the newest entries of the audit trail, oldest first."""
        with self.reading() as connection:
            return audit.newest(connection, limit)

    def audit_fault(self) -> str:
        """Return the change in, or the gap of, the audit trail; empty if it is intact."""
        with self.reading() as connection:
            return audit.fault(connection)

    def adopt(self, rows: RobotRows) -> None:
        """Record that these rows run, so that a later change without an edit is noticed."""
        with self.writing(patience_s=PATIENCE_S) as connection:
            adopted.remember(connection, rows.revision, rows.digest, self.wall_ns())

    def events(
        self, limit: int = 100, *, subject: str = "", levels: Sequence[str] = history.LEVELS
    ) -> tuple[Event, ...]:
        """Return the newest events, oldest first; optionally of one subject, or of some levels."""
        with self.reading() as connection:
            return history.newest_events(connection, limit, subject=subject, levels=levels)

    def last_change(self, robot: str, table: str, key: Sequence[object]) -> tuple[str, str] | None:
        """Return the time of a row's newest change, and its author if that was this program. None if it is old."""
        with self.reading() as connection:
            return history.last_change(connection, table, [key, (robot, *key)], self.program)

    def revisions(self, since: int = 0) -> tuple[RevisionRow, ...]:
        """Return every change of rows after revision `since`, oldest first."""
        with self.reading() as connection:
            return history.revisions(connection, since)

    def touched(self, since: int) -> tuple[RevisionRow, ...]:
        """Return the rows that were changed after revision `since`, without their content."""
        with self.reading() as connection:
            return history.revisions(connection, since, whole=False)

    def record_start(self, robot: str) -> None:
        """Record that the robot has started."""
        self._update_robot(robot, durable=False, last_start=self._now())

    def record_shutdown(self, robot: str) -> None:
        """Record that the robot has shut down in order."""
        self._update_robot(robot, durable=False, last_shutdown=self._now())

    def set_estop(self, robot: str, *, engaged: bool, reason: str) -> None:
        """Latch or release the emergency stop, on the disk on return; wait at most 0.1 s for other writers."""
        told = history.storable(reason)
        self._update_robot(robot, durable=True, patience_s=PATIENCE_S, estop_engaged=int(engaged), estop_reason=told)

    def revision(self) -> int:
        """Return the number of the last change of rows; 0 without one."""
        with self.reading() as connection:
            return adopted.revision(connection)

    def changes(self, since: int = 0) -> tuple[past.HistoryEntry, ...]:
        """Return every change of rows after revision `since`, oldest first, with author, program and rows."""
        with self.reading() as connection:
            return past.entries(history.revisions(connection, since), history.makers(connection))

    def tables_at(self, revision: int) -> RawTables:
        """Return the rows of all robots at a revision (0: a new database); raise InputError if that is unknown."""
        with self.reading() as connection:
            newest = adopted.revision(connection)
            if not 0 <= revision <= newest:
                raise InputError(f"there is no revision {revision} in {self.path}: 0 to {newest}", "unknown_name")
            tables, schema = read_tables(connection)
            with short_values(connection):
                return past.at(tables, schema, history.revisions(connection, revision))

    def around(self, revision: int, source: str) -> tuple[RawTables, RawTables, Schema]:
        """Return the rows before and after a change that this program made for `source`, by its last revision."""
        author = (history.storable(source)[: history.LONGEST], self.program)
        with self.reading() as connection:
            made = (one for one in history.makers(connection) if one.last_revision == revision)
            change = next((one for one in made if (one.source, one.program) == author), None)
            if change is None:
                raise InputError(f"revision {revision} ends no change of '{source}'", "unknown_name")
            tables, schema = read_tables(connection)
            with short_values(connection):
                newer = history.revisions(connection, change.first_revision - 1)
            return *past.around(tables, schema, newer, revision), schema

    def tokens(self) -> tuple[TokenRow, ...]:
        """Return every token's row, including revoked and expired ones."""
        with self.reading() as connection:
            return tokens.tokens(connection)

    def add_token(self, row: TokenRow) -> None:
        """Store a token's hash, durably; raise InputError if a token of this name is not revoked."""
        with self.writing(durable=True) as connection:
            tokens.add(connection, row)

    def rename_token(self, name: str, called: str) -> None:
        """Store a token's name for people; raise InputError for an unknown token, or an empty name."""
        with self.writing(durable=True) as connection:
            tokens.rename(connection, name, called)

    def revoke_token(self, name: str) -> None:
        """Revoke a token, durably; raise InputError if no valid token has this name."""
        with self.writing(durable=True) as connection:
            tokens.revoke(connection, name, self._now())

    def outdo(self, revision: int, text: str = "") -> None:
        """Record an edit that is newer than `revision`: every row may differ now."""
        with self.writing(durable=True) as connection, self.noted(connection, text=text):
            history.outdo(connection, revision)

    def close(self) -> None:
        """Close the file; may be repeated."""
        with self._lock:
            self._connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @contextmanager
    def noted(self, connection: Connection, by: str = "", text: str = "") -> Iterator[None]:
        """Record the author of the revisions made within; by default, this process's account."""
        before = adopted.revision(connection)
        yield
        if (after := adopted.revision(connection)) > before:
            change = past.ChangeRow(
                first_revision=before + 1, last_revision=after, source=by or account(), program=self.program, text=text
            )
            history.made(connection, change)

    def edit_entry(self, text: str) -> AuditRow:
        """Return a new entry of the audit trail for an edit of rows."""
        return AuditRow(wall_ns=self.wall_ns(), kind="edit", subject="rows", source=self.program, text=text)

    def _begin(self) -> None:
        self._until_cpu_s = time.thread_time() + self._computed_s

    def _prepare(self) -> None:
        connection = self._connection
        if not self.path.stat().st_size:  # sqlite3 leaves an empty file after a change of a missing one
            raise RowError((f"database {self.path} is empty: remove it, and `lbr db init` makes a robot's",))
        if fault := identity.fault(connection):
            raise RowError((f"database {self.path} {fault}: `lbr db restore` puts the last good copy in its place",))
        pragma(connection, "journal_mode = WAL")
        pragma(connection, "synchronous = NORMAL")
        pragma(connection, "foreign_keys = ON")
        self.backup = bring_up_to_date(connection, self.path)
        identity.number(connection)

    @contextmanager
    def reading(self, patience_s: float = BUSY_TIMEOUT_S) -> Iterator[Connection]:
        """Read in one transaction."""
        with self._lock, sentences(self.path):
            self._begin()
            pragma(self._connection, f"busy_timeout = {patience_s * 1000:.0f}")
            with transaction(self._connection, "DEFERRED") as connection:
                yield connection

    @contextmanager
    def writing(self, *, durable: bool = False, patience_s: float = BUSY_TIMEOUT_S) -> Iterator[Connection]:
        """Write in one transaction. `durable` waits for the disk after it, so that other writers need not wait as
        well."""
        with self._lock, sentences(self.path):
            self._begin()
            pragma(self._connection, f"busy_timeout = {patience_s * 1000:.0f}")
            with transaction(self._connection, "IMMEDIATE") as connection:
                yield connection
            if durable:
                flush_log(self.path)

    def _update_robot(
        self, robot: str, *, durable: bool, patience_s: float = BUSY_TIMEOUT_S, **columns: str | int
    ) -> None:
        with self.writing(durable=durable, patience_s=patience_s) as connection:
            done = connection.execute(statements.update("robot", columns, ["name"]), (*columns.values(), robot))
            if done.rowcount != 1:
                raise RowError((f"database {self.path} has no robot '{robot}': name one of its robots",))

    def _now(self) -> str:
        return moment_text(datetime.fromtimestamp(self.wall_ns() / 1e9, tz=UTC))
