"""Changed rows: the difference of two sets of tables, in words and in SQL. Pure except for `write`."""

import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from msgspec import Struct

from lbr.database import constraints, statements
from lbr.database.connection import Connection, insert
from lbr.database.difference import Difference, changed_columns
from lbr.database.reading import ROBOT, RawRow, RawTables
from lbr.database.tables import WRITTEN_BY_LBR, Schema, read_tables
from lbr.errors import InputError, RowError
from lbr.messages.rows import Key, short


class Change(Struct, frozen=True):
    """One row to write, before and after; None without one. The key has the order of the table."""

    table: str
    key: Key
    before: RawRow | None
    after: RawRow | None

    @property
    def robot(self) -> str | None:
        """Return the robot of the row, None for a row that all robots share."""
        values = self.after or self.before or {}
        return values.get("name" if self.table == ROBOT else "robot")

    @property
    def row(self) -> str:
        """Return the key, for people."""
        return "/".join(map(short, self.key))

    @property
    def difference(self) -> Difference:
        """Return the change, for people."""
        if self.before is None:
            return Difference(table=self.table, row=self.row, change="added")
        if self.after is None:
            return Difference(table=self.table, row=self.row, change="removed")
        columns = changed_columns(self.table, self.before, self.after)
        return Difference(table=self.table, row=self.row, change="changed", columns=columns)


def between(before: RawTables, after: RawTables, schema: Schema, robot: str | None = None) -> tuple[Change, ...]:
    """Return the changes from some tables to others, or those of one robot, without columns that lbr writes."""
    changes = (change for table in schema.keys_of for change in _of_table(table, before, after, schema))
    return tuple(change for change in changes if robot is None or change.robot == robot)


def differences(changes: Iterable[Change]) -> tuple[Difference, ...]:
    """Return changes, for people."""
    return tuple(change.difference for change in changes)


def applied(tables: RawTables, schema: Schema, changes: Iterable[Change]) -> RawTables:
    """Return the tables as they are after some changes."""
    by_table: dict[str, list[Change]] = {}
    for change in changes:
        by_table.setdefault(change.table, []).append(change)
    after = dict(tables)
    for table, of_table in by_table.items():
        rows = _by_key(tables, table, schema)
        for change in of_table:
            rows.pop(change.key, None)
            if change.after is not None:
                rows[change.key] = change.after
        after[table] = [rows[key] for key in sorted(rows, key=_order)]
    return after


def write(connection: Connection, changes: Sequence[Change], schema: Schema) -> None:
    """Write changes in the open transaction; RowError names a row that SQLite refuses.

    A row may come before the rows that it refers to. Updates go first: a row that now refers to another row stays when
    its former target is deleted. Columns that only lbr writes stay.
    """
    removes = any(change.after is None for change in changes)
    tables = set(schema.keys_of) if removes else {change.table for change in changes}
    dangling = _dangling(connection, tables)
    connection.execute("PRAGMA defer_foreign_keys = ON")
    for change in sorted(changes, key=lambda change: (change.before is None, change.after is None)):
        with _naming(change):
            _write(connection, change, schema)
    if new := sorted(_dangling(connection, tables) - dangling, key=str):
        table, parent = new[0][0], new[0][2]
        raise RowError((f"a row of {table} would refer to a row of {parent} that is not there: nothing was changed",))


def write_exactly(connection: Connection, changes: Sequence[Change], schema: Schema) -> None:
    """Write changes as `write` does; InputError if other rows would change with them."""
    before, _ = read_tables(connection)
    write(connection, changes, schema)
    after, _ = read_tables(connection)
    if others := between(applied(before, schema, changes), after, schema):
        raise InputError(
            f"{others[0].table} '{others[0].row}' would change with them, because it refers to a row that is taken"
            " out: nothing was changed",
            "refused",
        )


def _write(connection: Connection, change: Change, schema: Schema) -> None:
    key = schema.keys_of[change.table]
    if change.after is None:
        connection.execute(statements.delete(change.table, key), change.key)
        return
    own = {name: value for name, value in change.after.items() if (change.table, name) not in WRITTEN_BY_LBR}
    if change.before is None:
        insert(connection, change.table, [own])
    elif values := {name: value for name, value in own.items() if value != change.before.get(name)}:
        connection.execute(statements.update(change.table, values, key), (*values.values(), *change.key))


def _dangling(connection: Connection, tables: Iterable[str]) -> set[tuple[object, ...]]:
    """Return the rows of some tables that refer to a missing row; without a removal, only changed tables have new
    ones."""
    check = "SELECT * FROM pragma_foreign_key_check(?)"
    return {row for table in tables for row in connection.execute(check, (table,))}


@contextmanager
def _naming(change: Change) -> Iterator[None]:
    """Add the row to SQLite's refusal."""
    try:
        yield
    except (sqlite3.IntegrityError, sqlite3.InterfaceError, OverflowError) as err:
        why = constraints.words(str(err), getattr(err, "statement", ""))
        raise RowError((f"{change.table} '{change.row}': {why}",)) from err


def _of_table(table: str, before: RawTables, after: RawTables, schema: Schema) -> Iterator[Change]:
    old, new = _by_key(before, table, schema), _by_key(after, table, schema)
    for key in {**old, **new}:
        was, now = old.get(key), new.get(key)
        if was is None or now is None or changed_columns(table, was, now):
            yield Change(table, key, was, now)


def _by_key(tables: RawTables, table: str, schema: Schema) -> dict[Key, RawRow]:
    return {tuple(row[name] for name in schema.keys_of[table]): row for row in tables.get(table, ())}


def _order(key: Key) -> tuple[tuple[bool, object], ...]:
    """Return a sort key that orders keys as SQLite does, even keys that no column can hold."""
    return tuple((isinstance(part, str), 0 if part is None else part) for part in key)
