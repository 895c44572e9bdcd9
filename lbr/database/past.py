"""Rows at an earlier revision, and the authors of revisions. Pure.

tables of now ──► undo the newer revisions, the newest first ──► tables of then
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timedelta
from typing import Annotated

from msgspec import Meta, Struct

from lbr.database.difference import Difference, changed_columns, same
from lbr.database.reading import RawRow, RawTables
from lbr.database.rows import RevisionRow
from lbr.database.tables import Schema
from lbr.errors import InputError
from lbr.messages.rows import Key, Row, short
from lbr.messages.shapes import Shape

TOGETHER = timedelta(seconds=0.5)
"""Revisions of another SQLite client that follow each other this closely are shown as one change."""
ALIKE = 1e-14
"""SQLite writes 15 digits of a number into a revision."""


class ChangeRow(Row, frozen=True, kw_only=True):
    """The author and the program of each change that lbr made. A revision outside these is another SQLite client's."""

    TABLE = "change"
    KEY = ("first_revision",)
    SHARED = True

    first_revision: Annotated[int, "its first revision"]
    last_revision: Annotated[
        int, Meta(extra={"shape": Shape("{x} >= first_revision", "at least first_revision")}), "its last one"
    ]
    source: Annotated[str, "an account here, a capability, or a page's user"]
    program: Annotated[str, "such as lbr db rollback, executive"]
    text: Annotated[str, "its purpose, in one sentence"] = ""


class HistoryEntry(Struct, frozen=True, kw_only=True):
    """Revisions that belong together. Without a `program`, `text` has the reason why it is unknown."""

    first: int
    last: int
    at: str
    source: str = ""
    program: str = ""
    text: str = ""
    rows: tuple[RevisionRow, ...] = ()


def at(tables: RawTables, schema: Schema, newer: Sequence[RevisionRow]) -> RawTables:
    """Return the tables before the revisions `newer`, which are oldest first; raise InputError if that is
    impossible."""
    by_key = {
        table: {tuple(row[name] for name in key): row for row in tables.get(table, ())}
        for table, key in schema.keys_of.items()
    }
    for revision in reversed(newer):
        if revision.table not in by_key:
            raise _lost(revision, f"there is no table '{short(revision.table)}' any more")
        _undo(by_key[revision.table], schema, revision)
    return {table: [rows[key] for key in sorted(rows)] for table, rows in by_key.items()}


def around(tables: RawTables, schema: Schema, newer: Sequence[RevisionRow], last: int) -> tuple[RawTables, RawTables]:
    """Return the tables before and after the revisions up to `last`; `newer` are these and later ones, oldest first."""
    after = at(tables, schema, [revision for revision in newer if revision.id > last])
    return at(after, schema, [revision for revision in newer if revision.id <= last]), after


def of_revision(revision: RevisionRow) -> Difference:
    """Return one revision, for people; a renamed row counts as changed."""
    row = "/".join(map(short, revision.row_key))
    if revision.before is None or revision.after is None:
        what = {"insert": "added", "delete": "removed"}.get(revision.operation, "changed")
        return Difference(table=revision.table, row=row, change=what)  # type: ignore[arg-type]  # of the three
    columns = changed_columns(revision.table, revision.before, revision.after)
    return Difference(table=revision.table, row=row, change="changed", columns=columns)


def entries(revisions: Iterable[RevisionRow], known: Iterable[ChangeRow]) -> tuple[HistoryEntry, ...]:
    """Return revisions grouped by their change, oldest first; those of other programs by their time."""
    ahead = sorted(known, key=lambda change: change.first_revision, reverse=True)
    groups: list[list[RevisionRow]] = []
    causes: list[ChangeRow | None] = []
    for revision in revisions:
        while ahead and ahead[-1].last_revision < revision.id:
            ahead.pop()
        covering = ahead[-1] if ahead and ahead[-1].first_revision <= revision.id else None
        same = bool(groups) and causes[-1] is covering
        if same and (covering is None or not covering.program):
            same = _at(revision) - _at(groups[-1][-1]) <= TOGETHER
        if same:
            groups[-1].append(revision)
        else:
            groups.append([revision])
            causes.append(covering)
    return tuple(_change(rows, by) for rows, by in zip(groups, causes, strict=True))


def _undo(rows: dict[Key, RawRow], schema: Schema, revision: RevisionRow) -> None:
    """Undo one revision, the newest that is not undone yet."""
    before, after, table = revision.before, revision.after, revision.table
    if before is None and after is None:
        raise _lost(revision, "the whole database was replaced by a copy then (`lbr db restore`)")
    key_of = schema.keys_of[table]
    for values in (before, after):
        for name in values or ():
            if name not in schema[table]:
                raise _lost(revision, f"an upgrade of lbr has taken the column '{short(name)}' from {table} since")
        if values is not None and any(name not in values for name in key_of):
            raise _lost(revision, f"an upgrade of lbr has changed what names a row of {table} since")
    now: RawRow | None = None
    if after is not None:
        now = rows.pop(tuple(after[name] for name in key_of), None)
        if now is None or any(
            not _alike(now.get(name), value) and not same(now.get(name), value) for name, value in after.items()
        ):
            raise _lost(revision, f"{table} '{'/'.join(revision.row_key)}' was changed since with its triggers off")
    if before is not None:
        key = tuple(before[name] for name in key_of)
        if key in rows:
            raise _lost(revision, f"{table} '{'/'.join(revision.row_key)}' was written since with its triggers off")
        rows[key] = {name: _before(name, now, before, after, schema, revision) for name in schema[table]}


def _before(
    name: str,
    now: RawRow | None,
    before: Mapping[str, object],
    after: Mapping[str, object] | None,
    schema: Schema,
    of: RevisionRow,
) -> object:
    """Return the former value of a column: exactly, if the row's change left it as it is."""
    unchanged = now is not None and after is not None and _alike(before.get(name), after.get(name, math.nan))
    if name in before and not unchanged:
        return before[name]
    if now is not None:
        return now[name]
    try:
        return schema.default(of.table, name)
    except LookupError:
        raise _lost(
            of, f"an upgrade of lbr has given {of.table} the column '{name}' since, without a default"
        ) from None


def _alike(one: object, other: object) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return one == other or math.isclose(one, other, rel_tol=ALIKE, abs_tol=0.0)
    return type(one) is type(other) and bool(one == other)


def _lost(revision: RevisionRow, why: str) -> InputError:
    text = f"the rows before revision {revision.id} ({revision.changed_at}) cannot be restored any more: {why}"
    return InputError(f"{text}; nothing was changed", "not_possible")


def _at(revision: RevisionRow) -> datetime:
    try:
        return datetime.fromisoformat(revision.changed_at)
    except ValueError:
        return datetime.fromisoformat("1970-01-01T00:00:00Z")


def _change(rows: Sequence[RevisionRow], by: ChangeRow | None) -> HistoryEntry:
    first, last, at = rows[0].id, rows[-1].id, rows[-1].changed_at
    if by is None:
        return HistoryEntry(first=first, last=last, at=at, text="another SQLite client", rows=tuple(rows))
    return HistoryEntry(
        first=first, last=last, at=at, source=by.source, program=by.program, text=by.text, rows=tuple(rows)
    )
