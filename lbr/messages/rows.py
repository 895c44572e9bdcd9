"""A table as one struct, from which its SQL follows.

Annotations are the constraints of columns, and the texts in them their meaning. The docstring is the table's purpose.

    robot.db ── read, checked (lbr.database) ──► Phrase(…) ── one document ──► ctx.rows(Phrase)
             ◄── written by key ─────────────── learnt ◄──── heartbeat pipe ── ctx.learn(Phrase(…))

A kind names the rows that it reads and those that it may write back; nothing between knows a particular table.
"""

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Protocol, TypeVar

import msgspec
from msgspec import Meta, Raw, Struct

from lbr.messages.codes import Code
from lbr.messages.schema import JsonObject

R = TypeVar("R", bound="Row")
NOW = Meta(extra={"default": "(strftime('%Y-%m-%dT%H:%M:%fZ', 'now'))"})
"""For a column with the time at which its row was written, by default."""
COUNTED = Meta(extra={"counted": True})
"""For a number that SQLite assigns, and never twice."""
REQUIRED = Meta(extra={"default": None})
"""For a column that SQL requires, even with a default in Python."""
Key = tuple[Any, ...]
Fault = tuple[str, str]
"""A column, and its fault."""
Check = Callable[[Any, "Others"], Iterator[Fault]]
"""Yields the contradictions in a row, or with others. The check is skipped if it reads a bad column of the row."""


class Others(Protocol):
    """The rows of a robot for a check; reading an unreadable column ends the check."""

    def names(self, table: str) -> frozenset[Any]:
        """Return the column `name` of a table's rows, including bad ones."""

    def index(self, row: type[R], by: Callable[[R], Hashable]) -> Mapping[Hashable, R]:
        """Return the first row for each value of `by`."""


class Row(Struct, frozen=True, kw_only=True):
    """A row of TABLE, identified by KEY; each field is a column.

    The column `robot` is not a field: every table has it, except those that all robots share (SHARED). Rows OF another
    table are deleted with the row there whose name begins their key. Rows that are PART_OF a row are also written with
    it: its former parts are deleted. Of two ASCENDING columns the second is greater. Two columns TOGETHER are both NULL
    or both not. CHECKS are all further constraints.
    """

    TABLE: ClassVar[str] = ""
    KEY: ClassVar[tuple[str, ...]] = ()
    SHARED: ClassVar[bool] = False
    OF: ClassVar[str] = ""
    PART_OF: ClassVar[str] = ""
    ASCENDING: ClassVar[tuple[tuple[str, str], ...]] = ()
    TOGETHER: ClassVar[tuple[tuple[str, str], ...]] = ()
    CHECKS: ClassVar[tuple[Check, ...]] = ()

    @classmethod
    def whole(cls) -> str:
        """Return the table of the rows to which these belong; empty without one."""
        return cls.OF or cls.PART_OF

    @property
    def key(self) -> Key:
        """Return its key among the rows of its robot."""
        return tuple(getattr(self, column) for column in self.KEY)

    @property
    def full_name(self) -> str:
        """Return the row's table and key, for people."""
        return f"{self.TABLE} '{'/'.join(map(str, self.key))}'"

    def refusal(self, before: Mapping[str, object] | None, parts: Sequence["Row"]) -> tuple[str, Code] | None:  # noqa: ARG002
        """Return why a capability's edit may not write this row, or None.

        `before` are the present columns, `parts` the rows of other tables that come as parts of this one.
        """
        if getattr(self, "builtin", False) or (before or {}).get("builtin", 0) != 0:
            return f"{self.full_name} is built in, and stays as it is", "read_only"
        return None


class RowSet(Struct, frozen=True, kw_only=True):
    """Rows of one table in a document: JSON, in the order of their keys."""

    key: tuple[str, ...]
    part_of: str = ""
    rows: Raw


class RowsChanged(Struct, frozen=True, kw_only=True):
    """Rows edited while their reader runs, by table: JSON lists of new or changed ones, and of the keys `gone`."""

    rows: dict[str, str] = {}
    gone: dict[str, str] = {}


def row_set(row: type[Row], rows: Iterable[Row]) -> RowSet:
    """Return rows of one table for a document."""
    ordered = sorted(rows, key=lambda one: one.key)
    return RowSet(key=row.KEY, part_of=row.PART_OF, rows=Raw(msgspec.json.encode(ordered)))


def by_table(rows: Iterable[Row]) -> dict[str, Raw]:
    """Return rows by their tables, as JSON for others."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.TABLE, []).append(row)
    return {table: Raw(msgspec.json.encode(of_table)) for table, of_table in found.items()}


def changed(before: Mapping[str, RowSet], after: Mapping[str, RowSet]) -> RowsChanged:
    """Return the differences between the rows of tables."""
    rows, removed = {}, {}
    for table, now in after.items():
        if before.get(table) == now:
            continue
        known = _by_key(before[table]) if table in before else {}
        present = _by_key(now)
        rows[table] = msgspec.json.encode([row for key, row in present.items() if known.get(key) != row]).decode()
        removed[table] = msgspec.json.encode([key for key in known if key not in present]).decode()
    return RowsChanged(rows=rows, gone=removed)


def edited(known: Mapping[str, RowSet], rows: Iterable[type[Row]], edit: RowsChanged) -> dict[str, RowSet]:
    """Return the sets of rows after an edit; raise one of UNREADABLE if it cannot be read."""
    after = {}
    for row in rows:
        removed = msgspec.json.decode(edit.gone.get(row.TABLE, "[]"), type=list[tuple[str | int, ...]])
        new: list[Row] = msgspec.json.decode(edit.rows.get(row.TABLE, "[]"), type=list[row])  # type: ignore[valid-type]
        before: list[Row] = msgspec.json.decode(known[row.TABLE].rows, type=list[row])  # type: ignore[valid-type]
        kept = {one.key: one for one in before if one.key not in removed}
        after[row.TABLE] = row_set(row, (kept | {one.key: one for one in new}).values())
    return after


def changes(known: Mapping[str, RowSet], told: Mapping[str, Raw]) -> dict[str, Raw]:
    """Return the changed columns of known rows, with their keys, and new rows whole: other edits meanwhile stay."""
    return {table: _changes(known[table], rows) if table in known else rows for table, rows in told.items()}


def _changes(before: RowSet, rows: Raw) -> Raw:
    known = _by_key(before)
    changed_rows = []
    for row in msgspec.json.decode(rows, type=list[JsonObject]):
        known_row = known.get(tuple(row[column] for column in before.key), {})
        changed_rows.append(
            {
                name: row[name]
                for name in row
                if name in before.key or name not in known_row or known_row[name] != row[name]
            }
        )
    return Raw(msgspec.json.encode(changed_rows))


def with_rows(known: Mapping[str, RowSet], new: Mapping[str, Raw]) -> dict[str, RowSet]:
    """Return sets of rows with new rows, or with changes of known ones; unknown tables are left out."""
    told = {table: msgspec.json.decode(rows, type=list[JsonObject]) for table, rows in new.items()}
    return {
        table: before if table not in told and before.part_of not in told else _with(before, table, told)
        for table, before in known.items()
    }


def _with(before: RowSet, table: str, tables: Mapping[str, list[dict[str, object]]]) -> RowSet:
    known = _by_key(before)
    keyed = ((tuple(row[column] for column in before.key), row) for row in tables.get(table, ()))
    added = {key: {**known.get(key, {}), **row} for key, row in keyed}
    wholes = {row[before.key[0]] for row in added.values()} if before.part_of in tables else set()
    rows = {key: row for key, row in known.items() if row[before.key[0]] not in wholes} | added
    return msgspec.structs.replace(before, rows=Raw(msgspec.json.encode([rows[key] for key in sorted(rows)])))


def _by_key(rows: RowSet) -> dict[Key, dict[str, object]]:
    decoded = msgspec.json.decode(rows.rows, type=list[JsonObject])
    return {tuple(row[column] for column in rows.key): row for row in decoded}


def short(value: object) -> str:
    """Return a value as one short printable line."""
    text = value.decode(errors="replace") if isinstance(value, bytes) else str(value)
    if len(text) <= 60 and text.isprintable():  # as nearly all names of rows are
        return text
    return "".join(c if c.isprintable() else "?" for c in text[:60]) + ("…" if len(text) > 60 else "")
