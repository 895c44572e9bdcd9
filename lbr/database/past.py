"""Rows at an earlier revision, and what leads from some rows to others; pure but for `write`.

tables of now ──► undo the newer revisions, the newest first ──► tables of then ──► steps ──► one transaction forward
"""

import math
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import datetime, timedelta
from typing import Any

from msgspec import Struct

from lbr.database import constraints
from lbr.database.connection import Connection, insert, quoted
from lbr.database.difference import Difference, changed_columns, same
from lbr.database.reading import ROBOT, Problem, RawRow, RawTables
from lbr.database.rows import RevisionRow
from lbr.database.tables import WRITTEN_BY_LBR, Schema, read_tables
from lbr.errors import InputError, RowError
from lbr.messages.rows import shown

TOGETHER = timedelta(seconds=0.5)
"""Revisions of another SQLite client that follow each other this closely are told as one change: a transaction's take
less."""
ALIKE = 1e-14
"""SQLite writes 15 digits of a number into a revision."""
Key = tuple[Any, ...]
At = Callable[[int], RawTables]
"""Returns the tables as they were at a revision."""
Wanted = Callable[[RawTables, Schema, At], tuple["Step", ...]]
"""Returns what is to be done to the tables of now."""


class ChangeRow(Struct, frozen=True, kw_only=True):
    """Who made some revisions, and by what, as the table `change` has it."""

    first_revision: int
    last_revision: int
    source: str
    program: str
    text: str = ""


class Trial(Struct, frozen=True, kw_only=True):
    """Rows on trial, as the table `trial` has it: what goes back to the revision `back` unless it is ready in time."""

    revision: int
    back: int
    robot: str
    within_s: float
    state: str = "running"
    text: str = ""


class Change(Struct, frozen=True, kw_only=True):
    """Revisions that belong together. Without a `program`, `text` says why it is not known."""

    first: int
    last: int
    at: str
    source: str = ""
    program: str = ""
    text: str = ""
    rows: tuple[RevisionRow, ...] = ()


class Step(Struct, frozen=True):
    """One row to write: as it is, and as it is to be; None for no row."""

    table: str
    key: Key
    before: RawRow | None
    after: RawRow | None

    @property
    def robot(self) -> str | None:
        """Whose row it is; None if it is every robot's."""
        values = self.after or self.before or {}
        return values.get("name" if self.table == ROBOT else "robot")


class Became(Struct, frozen=True, kw_only=True):
    """What became of rows: the revisions before and after, what was done, and the new problems for which nothing
    was."""

    before: int
    revision: int
    steps: tuple[Step, ...] = ()
    problems: tuple[Problem, ...] = ()


def at(tables: RawTables, schema: Schema, newer: Sequence[RevisionRow]) -> RawTables:
    """Return the tables as they were before the revisions `newer`, oldest first; InputError says what keeps one from
    that."""
    found = {
        table: {tuple(row[name] for name in key): row for row in tables.get(table, ())}
        for table, key in schema.keys_of.items()
    }
    for revision in reversed(newer):
        if revision.table not in found:
            raise _lost(revision, f"there is no table '{shown(revision.table)}' any more")
        _undo(found[revision.table], schema, revision)
    return {table: [rows[key] for key in sorted(rows)] for table, rows in found.items()}


def steps(before: RawTables, after: RawTables, schema: Schema, robot: str | None = None) -> tuple[Step, ...]:
    """Return what leads from some tables to others; of one robot alone, if so asked. What lbr writes itself is none of
    it."""
    found = (step for table, key in schema.keys_of.items() for step in _of_table(table, key, before, after))
    return tuple(step for step in found if robot is None or step.robot == robot)


def done(tables: RawTables, schema: Schema, wanted: Iterable[Step]) -> RawTables:
    """Return the tables as they are after some steps."""
    by_table: dict[str, list[Step]] = {}
    for step in wanted:
        by_table.setdefault(step.table, []).append(step)
    after = dict(tables)
    for table, of_table in by_table.items():
        rows = {tuple(row[name] for name in schema.keys_of[table]): row for row in tables.get(table, ())}
        for step in of_table:
            rows.pop(step.key, None)
            if step.after is not None:
                rows[step.key] = step.after
        after[table] = [rows[key] for key in sorted(rows, key=_order)]
    return after


def told(wanted: Iterable[Step]) -> tuple[Difference, ...]:
    """Return steps as people read them."""
    return tuple(_told(step) for step in wanted)


def of_revision(revision: RevisionRow) -> Difference:
    """Return one revision as people read it; a row that got another name was changed."""
    row = "/".join(map(shown, revision.row_key))
    if revision.old is None or revision.new is None:
        what = {"insert": "added", "delete": "removed"}.get(revision.operation, "changed")
        return Difference(table=revision.table, row=row, change=what)  # type: ignore[arg-type]  # of the three
    columns = changed_columns(revision.table, revision.old, revision.new)
    return Difference(table=revision.table, row=row, change="changed", columns=columns)


def changes(revisions: Iterable[RevisionRow], known: Iterable[ChangeRow]) -> tuple[Change, ...]:
    """Return revisions by what they belong to, oldest first; those that lbr did not make by their moments."""
    ahead = sorted(known, key=lambda change: change.first_revision, reverse=True)
    found: list[list[RevisionRow]] = []
    who: list[ChangeRow | None] = []
    for revision in revisions:
        while ahead and ahead[-1].last_revision < revision.id:
            ahead.pop()
        covering = ahead[-1] if ahead and ahead[-1].first_revision <= revision.id else None
        same = bool(found) and who[-1] is covering
        if same and (covering is None or not covering.program):
            same = _at(revision) - _at(found[-1][-1]) <= TOGETHER
        if same:
            found[-1].append(revision)
        else:
            found.append([revision])
            who.append(covering)
    return tuple(_change(rows, by) for rows, by in zip(found, who, strict=True))


def refuse_other(revision: int, expected: int | None) -> None:
    """Raise InputError if the rows were changed since they were looked at."""
    if expected is not None and revision != expected:
        raise InputError(
            f"the rows have revision {revision}, not {expected}: they were changed meanwhile; look at them again",
            "changed",
        )


def new_problems(
    before: RawTables, after: RawTables, wanted: Sequence[Step], judge: Callable[[RawTables, str], Iterable[Problem]]
) -> tuple[Problem, ...]:
    """Return what steps make wrong; what was wrong before stands in no one's way. A robot that is latched is not taken
    out."""
    if not wanted:
        return ()
    robots = {row["name"]: row for row in before.get(ROBOT, ())}
    stays = [row["name"] for row in after.get(ROBOT, ())]
    found = [
        Problem(ROBOT, name, "estop_engaged", "its emergency stop is latched: 'reset' it before the robot is taken out")
        for name, row in robots.items()
        if name not in stays and row.get("estop_engaged")
    ]
    for name in stays:
        now = list(judge(after, name))
        was = list(judge(before, name)) if now and name in robots else []
        found += [one for one in now if one not in was and one not in found]
    return tuple(found)


def write(connection: Connection, wanted: Sequence[Step], schema: Schema) -> None:
    """Write steps in the transaction that is under way; InputError if the tables are then not as wanted.

    What refers to others may come before them. Updates go first: a row that refers to another now stays when the one
    it referred to is taken out.
    """
    before, _ = read_tables(connection)
    dangling = _dangling(connection)
    connection.execute("PRAGMA defer_foreign_keys = ON")
    for step in (one for one in wanted if one.before is not None and one.after is not None):
        _update(connection, step, schema)
    for step in (one for one in wanted if one.after is None):
        with _naming(step):
            statement = f"DELETE FROM {quoted(step.table)} WHERE {_where(step, schema)}"  # noqa: S608 - quoted
            connection.execute(statement, step.key)
    for step in (one for one in wanted if one.before is None and one.after is not None):
        with _naming(step):
            insert(connection, step.table, [_own(step.table, step.after or {})])
    if new := sorted(_dangling(connection) - dangling, key=str):
        table, parent = new[0][0], new[0][2]
        raise RowError((f"a row of {table} would refer to a row of {parent} that is not there: nothing was changed",))
    after, _ = read_tables(connection)
    if others := steps(done(before, schema, wanted), after, schema):
        raise InputError(
            f"{others[0].table} '{_name(others[0].key)}' would change with them, because it refers to a row that is taken"
            " out: nothing was changed",
            "refused",
        )


def _order(key: Key) -> tuple[tuple[bool, Any], ...]:
    """Sort keys as SQLite does, and those that no column can hold, too."""
    return tuple((isinstance(part, str), 0 if part is None else part) for part in key)


def _update(connection: Connection, step: Step, schema: Schema) -> None:
    before, after = step.before or {}, _own(step.table, step.after or {})
    values = {name: value for name, value in after.items() if value != before.get(name)}
    if values:
        settings = ", ".join(f"{quoted(name)} = ?" for name in values)
        statement = f"UPDATE {quoted(step.table)} SET {settings} WHERE {_where(step, schema)}"  # noqa: S608 - quoted
        with _naming(step):
            connection.execute(statement, (*values.values(), *step.key))


def _dangling(connection: Connection) -> set[tuple[Any, ...]]:
    return set(connection.execute("PRAGMA foreign_key_check").fetchall())


@contextmanager
def _naming(step: Step) -> Iterator[None]:
    """Name the row that SQLite refuses."""
    try:
        yield
    except (sqlite3.IntegrityError, sqlite3.InterfaceError, OverflowError) as err:
        told = constraints.words(str(err), getattr(err, "statement", ""))
        raise RowError((f"{step.table} '{_name(step.key)}': {told}",)) from err


def _where(step: Step, schema: Schema) -> str:
    return " AND ".join(f"{quoted(name)} = ?" for name in schema.keys_of[step.table])


def _own(table: str, row: RawRow) -> dict[str, Any]:
    """Return a row without what lbr alone writes."""
    return {name: value for name, value in row.items() if (table, name) not in WRITTEN_BY_LBR}


def _of_table(table: str, key_of: tuple[str, ...], before: RawTables, after: RawTables) -> Iterator[Step]:
    old, new = ({tuple(row[name] for name in key_of): row for row in rows.get(table, ())} for rows in (before, after))
    for key in {**old, **new}:
        one = Step(table, key, old.get(key), new.get(key))
        if one.before is None or one.after is None or changed_columns(table, one.before, one.after):
            yield one


def _told(step: Step) -> Difference:
    row = _name(step.key)
    if step.before is None:
        return Difference(table=step.table, row=row, change="added")
    if step.after is None:
        return Difference(table=step.table, row=row, change="removed")
    columns = changed_columns(step.table, step.before, step.after)
    return Difference(table=step.table, row=row, change="changed", columns=columns)


def _name(key: Key) -> str:
    return "/".join(map(shown, key))


def _undo(rows: dict[Key, RawRow], schema: Schema, revision: RevisionRow) -> None:
    """Take one revision back, the newest that has not been taken back yet."""
    old, new, table = revision.old, revision.new, revision.table
    if old is None and new is None:
        raise _lost(revision, "the whole database was replaced by a copy then (`lbr db restore`)")
    key_of = schema.keys_of[table]
    for values in (old, new):
        for name in values or ():
            if name not in schema[table]:
                raise _lost(revision, f"an upgrade of lbr has taken the column '{shown(name)}' from {table} since")
        if values is not None and any(name not in values for name in key_of):
            raise _lost(revision, f"an upgrade of lbr has changed what names a row of {table} since")
    now: RawRow | None = None
    if new is not None:
        now = rows.pop(tuple(new[name] for name in key_of), None)
        if now is None or any(
            not _alike(now.get(name), value) and not same(now.get(name), value) for name, value in new.items()
        ):
            raise _lost(revision, f"{table} '{'/'.join(revision.row_key)}' was changed since with its triggers off")
    if old is not None:
        key = tuple(old[name] for name in key_of)
        if key in rows:
            raise _lost(revision, f"{table} '{'/'.join(revision.row_key)}' was written since with its triggers off")
        rows[key] = {name: _before(name, now, old, new, schema, revision) for name in schema[table]}


def _before(
    name: str,
    now: RawRow | None,
    old: Mapping[str, Any],
    new: Mapping[str, Any] | None,
    schema: Schema,
    of: RevisionRow,
) -> Any:
    """Return what a column held: exactly, where a row's change left it as it is."""
    if name in old and not (now is not None and new is not None and _alike(old[name], new.get(name, math.nan))):
        return old[name]
    if now is not None:
        return now[name]
    try:
        return schema.default(of.table, name)
    except LookupError:
        raise _lost(
            of, f"an upgrade of lbr has given {of.table} the column '{name}' since, without a default"
        ) from None


def _alike(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return one == other or math.isclose(one, other, rel_tol=ALIKE, abs_tol=0.0)
    return type(one) is type(other) and bool(one == other)


def _lost(revision: RevisionRow, why: str) -> InputError:
    text = f"the rows before revision {revision.id} ({revision.changed_at}) cannot be told any more: {why}"
    return InputError(f"{text}; nothing was changed", "not_possible")


def _at(revision: RevisionRow) -> datetime:
    try:
        return datetime.fromisoformat(revision.changed_at)
    except ValueError:
        return datetime.fromisoformat("1970-01-01T00:00:00Z")


def _change(rows: Sequence[RevisionRow], by: ChangeRow | None) -> Change:
    first, last, at = rows[0].id, rows[-1].id, rows[-1].changed_at
    if by is None:
        return Change(first=first, last=last, at=at, text="another SQLite client", rows=tuple(rows))
    return Change(first=first, last=last, at=at, source=by.source, program=by.program, text=by.text, rows=tuple(rows))
