"""Edits of single rows that come from outside: what they make of the tables, and why not; pure but for `write`."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import msgspec

from lbr.database.columns import raw
from lbr.database.connection import Connection, insert, quoted
from lbr.database.reading import RawRow, RawTables
from lbr.database.rows import RevisionRow
from lbr.errors import InputError
from lbr.messages.codes import Code
from lbr.messages.faces import EditCommand
from lbr.messages.joints import Motion
from lbr.messages.rows import Row

Key = tuple[str, ...]


def describe(edit: EditCommand) -> str:
    """Return which rows an edit is about, for people."""
    return ", ".join(row.told for row in edit.rows if not row.PART_OF)


def applied(tables: RawTables, robot: str, edit: EditCommand, since: Iterable[RevisionRow] = ()) -> RawTables:
    """Return the tables as they are after an edit; InputError if it may not be made, in one sentence.

    `since` are the changes after the revision that the edit goes by.
    """
    rows = edit.rows
    if not rows:
        raise InputError("this edit has no rows")
    changed = set(_changed(since, robot, {row.TABLE: row.PART_OF for row in rows}))
    seen: set[tuple[str, Key]] = set()
    for row in rows:
        key = row.TABLE, _texts(row.key)
        if key in seen:
            raise InputError(f"{row.told} is there twice")
        seen.add(key)
        if not row.PART_OF:
            there = next((one for one in tables.get(row.TABLE, ()) if _key_of(row, one) == (robot, *key[1])), None)
            _refuse(row, there, edit, newer=key in changed)
    after: dict[str, Sequence[RawRow]] = dict(tables)
    for table, new in _by_table(rows).items():
        written = [{"robot": robot, **raw(row)} for row in new]
        gone = {_key_of(new[0], one) for one in written}
        wholes = {(robot, *key) for whole, key in seen if whole == new[0].PART_OF}
        keyed = ((_key_of(new[0], one), one) for one in tables.get(table, ()))
        after[table] = [*(one for key, one in keyed if key not in gone and key[:2] not in wholes), *written]
    return after


def write(connection: Connection, robot: str, rows: Sequence[Row]) -> None:
    """Write rows over those that are there; rows that stay as they are make no revision, parts of others go with them."""
    for table, new in _by_table(rows).items():
        if part_of := new[0].PART_OF:
            wholes = {row.key[0] for row in rows if part_of == row.TABLE}
            _clear(connection, robot, table, new, wholes)
        put(connection, robot, new, change=True)


def put(connection: Connection, robot: str, rows: Sequence[Row], *, change: bool) -> None:
    """Write rows of one table; those that are there are changed, or are in the way."""
    table, key, owner = rows[0].TABLE, rows[0].KEY, _owner(connection, robot, rows[0].TABLE)
    keys = ", ".join(quoted(name) for name in (*owner, *key))
    others = [quoted(name) for name in rows[0].__struct_fields__ if name not in key]
    update = "UPDATE SET " + ", ".join(f"{name} = excluded.{name}" for name in others) if others else "NOTHING"
    insert(connection, table, [owner | raw(row) for row in rows], f"ON CONFLICT ({keys}) DO {update}" if change else "")


def change(connection: Connection, robot: str, row: Row, before: Mapping[str, Any]) -> None:
    """Write what is another in a row than `before`; nothing if the row is gone."""
    after, key = (
        msgspec.to_builtins(row),
        _owner(connection, robot, row.TABLE) | dict(zip(row.KEY, row.key, strict=True)),
    )
    new = {name: value for name, value in raw(row).items() if after[name] != before.get(name)}
    if new:
        settings, where = (
            join.join(f"{quoted(name)} = ?" for name in part) for join, part in ((", ", new), (" AND ", key))
        )
        statement = f"UPDATE {quoted(row.TABLE)} SET {settings} WHERE {where}"  # noqa: S608 - quoted
        connection.execute(statement, (*new.values(), *key.values()))


def _owner(connection: Connection, robot: str, table: str) -> dict[str, Any]:
    """Return the column that says whose a row is; none for rows that are every robot's."""
    owned = connection.scalar("SELECT count(*) FROM pragma_table_info(?) WHERE name = 'robot'", (table,))
    return {"robot": robot} if owned else {}


def _clear(connection: Connection, robot: str, table: str, new: Sequence[Row], wholes: Iterable[Any]) -> None:
    """Take out the parts of what is written that are not there any more."""
    whole, part = map(quoted, new[0].KEY)
    for one in wholes:
        kept = [row.key[1] for row in new if row.key[0] == one]
        marks = ", ".join(["?"] * len(kept))
        connection.execute(
            f"DELETE FROM {quoted(table)} WHERE robot = ? AND {whole} = ? AND {part} NOT IN ({marks})",  # noqa: S608
            (robot, one, *kept),
        )


def _refuse(row: Row, there: RawRow | None, edit: EditCommand, *, newer: bool) -> None:
    """Raise InputError if a row may not be written."""
    motion = next((one for one in edit.motions if one.row == row), None)
    whys: dict[tuple[str, Code], bool] = {
        (f"{row.told} is there already", "exists"): edit.create and there is not None,
        (f"there is no {row.told}", "unknown_name"): not edit.create and there is None,
        (f"{row.told} is built in, and stays as it is", "read_only"): getattr(row, "builtin", False)
        or (there is not None and there.get("builtin", 0) != 0),
        (
            f"{row.told} would be in a slot: what the controller keeps is entered at the robot itself",
            "not_possible",
        ): _is_stored(motion),
        (f"{row.told} is in a slot, kept by the controller: its row is edited at the robot itself", "read_only"): (
            there is not None and there.get("slot") is not None
        ),
        (f"{row.told} has no key frames", "bad_value"): motion is not None and not motion.frames,
        (f"{row.told} has changed since revision {edit.revision}: look at it again", "changed"): newer,
    }
    if why := next((why for why, holds in whys.items() if holds), None):
        raise InputError(*why)


def _is_stored(motion: Motion | None) -> bool:
    return motion is not None and (motion.slot, motion.slot_s, motion.limp) != (None, None, False)


def _changed(since: Iterable[RevisionRow], robot: str, parts: Mapping[str, str]) -> Iterator[tuple[str, Key]]:
    """Yield table and key, without the robot, of rows that were changed; a part counts as its whole."""
    for row in since:
        if row.row_key[:1] == (robot,):
            whole = parts.get(row.table, "")
            yield (whole, row.row_key[1:2]) if whole else (row.table, row.row_key[1:])


def _by_table(rows: Iterable[Row]) -> dict[str, list[Row]]:
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.TABLE, []).append(row)
    return found


def _key_of(row: Row, values: RawRow) -> Key:
    return _texts(values.get(column) for column in ("robot", *row.KEY))


def _texts(key: Iterable[Any]) -> Key:
    return tuple(map(str, key))
