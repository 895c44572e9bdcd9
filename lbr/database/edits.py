"""Edits of single rows that come from outside: what they make of the tables, and why not; pure but for `write`."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import msgspec
from msgspec import Struct

from lbr.database.columns import raw
from lbr.database.connection import Connection, insert, quoted
from lbr.database.reading import ROBOT, RawRow, RawTables
from lbr.database.rows import RevisionRow
from lbr.errors import InputError
from lbr.messages.faces import EditCommand
from lbr.messages.rows import Row, shown
from lbr.messages.unreadable import UNREADABLE

Key = tuple[str, ...]
MAKE_PROCESSES = {ROBOT, "capability", "channel", "device", "verb", "external_command"}
"""What every robot has: such rows say which programs run, and what may reach what. No edit on another's behalf writes
them."""


DESCRIBE = ("model", "description", "owner")
"""The columns of a robot's own row that an edit writes."""


class Edit(Struct, frozen=True, kw_only=True):
    """Rows to write, as `EditCommand` has them; read, and allowed to the asker.

    `create` says whether they must be new, or there already; None takes both. `source` is the capability that asks.
    """

    rows: tuple[Row, ...]
    create: bool | None = False
    revision: int | None = None
    by: str = ""
    source: str = ""

    @property
    def author(self) -> str:
        """Who makes it: the capability that asks, and for whom; empty for whose program this is."""
        return " for ".join(filter(None, (self.source, self.by)))

    def __str__(self) -> str:
        return ", ".join(row.told for row in self.rows if not row.PART_OF)


def understood(command: EditCommand, allowed: Iterable[type[Row]]) -> Edit:
    """Return an edit of rows of these tables; InputError names the table that is none of them, or what is no row."""
    tables = {row.TABLE: row for row in allowed if row.TABLE not in MAKE_PROCESSES}
    rows: list[Row] = []
    for table, found in command.rows.items():
        if table not in tables:
            raise InputError(f"rows of '{shown(table)}' are not for it to write; it may {_listed(tables)}", "denied")
        try:
            rows += msgspec.json.decode(found, type=list[tables[table]])  # type: ignore[valid-type]
        except UNREADABLE as err:
            raise InputError(f"malformed edit: {table}: {err}", "malformed") from err
    return Edit(rows=tuple(rows), create=command.create, revision=command.revision, by=command.by)


def applied(tables: RawTables, robot: str, edit: Edit, since: Iterable[RevisionRow] = ()) -> RawTables:
    """Return the tables as they are after an edit; InputError if it may not be made, in one sentence.

    `since` are the changes after the revision that the edit goes by.
    """
    rows = edit.rows
    if not rows:
        raise InputError("this edit has no rows")
    changed = set(_changed(since, robot, {row.TABLE: row.PART_OF for row in rows}))
    seen: set[tuple[str, Key]] = set()
    parts = _parts(rows)
    for row in rows:
        key = row.TABLE, _texts(row.key)
        if key in seen:
            raise InputError(f"{row.told} is there twice")
        seen.add(key)
        if not row.PART_OF:
            mine = (*_owned_by(row, robot), *key[1])
            there = next((one for one in tables.get(row.TABLE, ()) if _key_of(row, one) == mine), None)
            _refuse(row, there, edit, parts.pop(key, ()), newer=key in changed)
    if parts:
        (table, whole), (part, *_) = next(iter(parts.items()))
        raise InputError(
            f"{part.told} is a part of {table} '{'/'.join(whole)}', which this edit does not have", "bad_value"
        )
    after: dict[str, Sequence[RawRow]] = dict(tables)
    for table, new in _by_table(rows).items():
        written = [{**dict.fromkeys(_owned_by(row, ROBOT), robot), **raw(row)} for row in new]
        gone = {_key_of(new[0], one) for one in written}
        wholes = {(robot, *key) for whole, key in seen if whole == new[0].PART_OF}
        keyed = ((_key_of(new[0], one), one) for one in tables.get(table, ()))
        after[table] = [*(one for key, one in keyed if key not in gone and key[:2] not in wholes), *written]
    return after


def write(connection: Connection, robot: str, rows: Sequence[Row]) -> None:
    """Write rows over those that are there; rows that stay as they are make no revision, parts of others go with
    them."""
    for table, new in _by_table(rows).items():
        if table == ROBOT:
            _describe(connection, new)
            continue
        if part_of := new[0].PART_OF:
            wholes = {row.key[0] for row in rows if part_of == row.TABLE}
            _clear(connection, robot, table, new, wholes)
        put(connection, robot, new, change=True)


def _describe(connection: Connection, rows: Sequence[Row]) -> None:
    """Write what people say of a robot; the emergency stop and the times in its row are never an edit's."""
    for row in rows:
        values = raw(row)
        settings = ", ".join(f"{name} = ?" for name in DESCRIBE)
        statement = f"UPDATE robot SET {settings} WHERE name = ?"  # noqa: S608 - our names
        connection.execute(statement, (*(values[name] for name in DESCRIBE), values["name"]))


def with_setting(tables: RawTables, robot: str, capability: str, setting: str, value: Any) -> RawTables:
    """Return the tables as they are with another setting of a capability; InputError if there is no such row."""
    rows = tables.get("capability", ())
    if not any((row["robot"], row["name"]) == (robot, capability) for row in rows):
        raise InputError(f"there is no capability '{capability}'", "unknown_name")

    def changed(row: RawRow) -> RawRow:
        if (row["robot"], row["name"]) != (robot, capability):
            return row
        try:
            settings = msgspec.json.decode(str(row["settings"]), type=dict[str, Any]) | {setting: value}
        except UNREADABLE as err:
            raise InputError(f"the settings of '{capability}' are not a JSON object: {err}", "malformed") from err
        return {**row, "settings": msgspec.json.encode(settings).decode()}

    return {**tables, "capability": [changed(row) for row in rows]}


def write_setting(connection: Connection, robot: str, capability: str, setting: str, value: Any) -> None:
    """Write one setting of a capability; the text of its others stays."""
    statement = "UPDATE capability SET settings = json_set(settings, ?, json(?)) WHERE robot = ? AND name = ?"
    connection.execute(statement, (f"$.{setting}", msgspec.json.encode(value).decode(), robot, capability))


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


def _refuse(row: Row, there: RawRow | None, edit: Edit, parts: Sequence[Row], *, newer: bool) -> None:
    """Raise InputError if a row may not be written."""
    if edit.create is True and there is not None:
        raise InputError(f"{row.told} is there already", "exists")
    if (edit.create is False or row.TABLE == ROBOT) and there is None:
        raise InputError(f"there is no {row.told}", "unknown_name")
    if why := row.refusal(there, parts):
        raise InputError(*why)
    if newer:
        raise InputError(f"{row.told} has changed since revision {edit.revision}: look at it again", "changed")


def _parts(rows: Iterable[Row]) -> dict[tuple[str, Key], tuple[Row, ...]]:
    """Return the rows that are parts of others, by table and key of those."""
    found: dict[tuple[str, Key], tuple[Row, ...]] = {}
    for row in rows:
        if row.PART_OF:
            whole = row.PART_OF, _texts(row.key[:1])
            found[whole] = (*found.get(whole, ()), row)
    return found


def _listed(tables: Iterable[str]) -> str:
    return "write " + ", ".join(sorted(tables)) if tables else "write none"


def _changed(since: Iterable[RevisionRow], robot: str, parts: Mapping[str, str]) -> Iterator[tuple[str, Key]]:
    """Yield table and key, without the robot, of rows that were changed; a part counts as its whole."""
    for row in since:
        if row.row_key[:1] == (robot,):
            whole = parts.get(row.table, "")
            own = row.row_key if row.table == ROBOT else row.row_key[1:]
            yield (whole, own[:1]) if whole else (row.table, own)


def _by_table(rows: Iterable[Row]) -> dict[str, list[Row]]:
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.TABLE, []).append(row)
    return found


def _owned_by(row: Row, robot: str) -> Key:
    """Return what goes before a row's key; a robot's own row is told by its name alone."""
    return () if row.TABLE == ROBOT else (robot,)


def _key_of(row: Row, values: RawRow) -> Key:
    return _texts(values.get(column) for column in (*_owned_by(row, ROBOT), *row.KEY))


def _texts(key: Iterable[Any]) -> Key:
    return tuple(map(str, key))
