"""Edits of whole rows, for capabilities and imports, and learnt rows."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import msgspec

from lbr.database import changes
from lbr.database.changes import Change
from lbr.database.columns import raw
from lbr.database.proposals import Judge, Proposed, propose
from lbr.database.reading import ROBOT, RawRow, RawTables
from lbr.database.rows import CORE, RevisionRow
from lbr.database.store import Database
from lbr.database.tables import Schema
from lbr.errors import InputError
from lbr.messages.faces import EditCommand
from lbr.messages.rows import Key, Row, short
from lbr.messages.unreadable import UNREADABLE

KeyTexts = tuple[str, ...]
RowKey = tuple[str, Key]
"""Table and key of a row of one robot."""
MAKE_PROCESSES = {row.TABLE for row in CORE}
"""The tables of every robot: their rows choose the programs that run, and their rights. Edits of capabilities never
write them."""


def understood(command: EditCommand, allowed: Iterable[type[Row]]) -> tuple[Row, ...]:
    """Return an edit's rows of these tables. InputError names another table, or a bad row."""
    tables = {row.TABLE: row for row in allowed if row.TABLE not in MAKE_PROCESSES}
    rows: list[Row] = []
    for table, of_table in command.rows.items():
        if table not in tables:
            raise InputError(f"rows of '{short(table)}' are not for it to write; it may {_listed(tables)}", "denied")
        try:
            rows += msgspec.json.decode(of_table, type=list[tables[table]])  # type: ignore[valid-type]
        except UNREADABLE as err:
            raise InputError(f"malformed edit: {table}: {err}", "malformed") from err
    return tuple(rows)


def names(rows: Iterable[Row]) -> str:
    """Return the names of these rows, for people."""
    return ", ".join(row.full_name for row in rows if not row.PART_OF)


def write_rows(
    database: Database,
    robot: str,
    rows: Sequence[Row],
    judge: Judge,
    *,
    create: bool | None = False,
    revision: int | None = None,
    by: str = "",
    dry_run: bool = False,
) -> Proposed:
    """Propose new rows, or rows in place of old ones, all or none. The robot's rows must be good then.

    `create` true is for new rows, false for old ones, None for both. The rows must not have changed since `revision`.
    The parts of a row replace all its old parts. InputError has the reason against the rows.
    """

    def wanted(tables: RawTables, schema: Schema) -> tuple[Change, ...]:
        newer = () if revision is None else database.touched(revision)
        after = _with_rows(tables, schema, robot, rows, create, newer, revision)
        return changes.between(tables, after, schema)

    return propose(database, wanted, judge, robot=robot, mending=False, by=by, dry_run=dry_run)


def write_setting(
    database: Database, robot: str, capability: str, setting: str, value: object, judge: Judge, *, by: str = ""
) -> Proposed:
    """Propose a new value of a setting. All others stay, and the robot's rows must be good then."""

    def wanted(tables: RawTables, schema: Schema) -> tuple[Change, ...]:
        return changes.between(tables, with_setting(tables, robot, capability, setting, value), schema)

    return propose(database, wanted, judge, robot=robot, mending=False, by=by)


def learn(
    database: Database,
    robot: str,
    rows: Sequence[Row],
    known: Mapping[RowKey, Mapping[str, object]] | None = None,
    *,
    by: str = "",
) -> None:
    """Write the rows that a capability has learnt, all or none. On return they are on the disk. Its former rows are
    `known`, by table and key. Only the columns that differ are written. Edits of others stay, and a deleted row stays
    deleted. Each other row must be new."""
    with database.writing(durable=True) as connection, database.noted(connection, by):
        schema = Schema(connection)
        changes.write(connection, [_learnt(row, robot, known or {}, schema) for row in rows], schema)


def with_setting(tables: RawTables, robot: str, capability: str, setting: str, value: object) -> RawTables:
    """Return the tables with another setting of a capability; raise InputError if there is no such row."""
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


def _with_rows(
    tables: RawTables,
    schema: Schema,
    robot: str,
    rows: Sequence[Row],
    create: bool | None,
    newer: Iterable[RevisionRow],
    revision: int | None,
) -> RawTables:
    """Return the tables with these rows; raise InputError with the reason against them, in one sentence."""
    if not rows:
        raise InputError("this edit has no rows")
    by_table: dict[str, list[Row]] = {}
    for row in rows:
        by_table.setdefault(row.TABLE, []).append(row)
    if missing := [table for table in by_table if table not in schema]:
        raise InputError(f"there is no table '{missing[0]}'", "unknown_name")
    part_of = {table: of_table[0].PART_OF for table, of_table in by_table.items()}
    changed = set(_changed(newer, robot, schema, part_of))
    existing = {table: _own(tables, of_table[0], robot) for table, of_table in by_table.items()}
    written: set[tuple[str, KeyTexts]] = set()
    parts = _parts(rows)
    for row in rows:
        key = row.TABLE, _texts(row.key)
        if key in written:
            raise InputError(f"{row.full_name} is there twice")
        written.add(key)
        if not row.PART_OF:
            _refuse(row, existing[row.TABLE].get(key[1]), create, parts.pop(key, ()))
            if key in changed:
                raise InputError(f"{row.full_name} has changed since revision {revision}: look at it again", "changed")
    if parts:
        (table, whole), (part, *_) = next(iter(parts.items()))
        raise InputError(
            f"{part.full_name} is a part of {table} '{'/'.join(whole)}', which this edit does not have", "bad_value"
        )
    after: dict[str, Sequence[RawRow]] = dict(tables)
    for table, of_table in by_table.items():
        mine = existing[table]
        others = [values for values in tables.get(table, ()) if values.get("robot", robot) != robot]
        kept = {key: values for key, values in mine.items() if (part_of[table], key[:1]) not in written}
        owner = _owner(table, robot, schema)
        new = {_texts(row.key): {**mine.get(_texts(row.key), {}), **owner, **raw(row)} for row in of_table}
        after[table] = [*others, *{**kept, **new}.values()]
    return after


def _learnt(row: Row, robot: str, known: Mapping[RowKey, Mapping[str, object]], schema: Schema) -> Change:
    values = {**_owner(row.TABLE, robot, schema), **raw(row)}
    key = tuple(values[name] for name in schema.keys_of[row.TABLE])
    before = known.get((row.TABLE, row.key))
    if before is None:
        return Change(row.TABLE, key, None, values)
    now = msgspec.to_builtins(row)
    return Change(row.TABLE, key, {}, {name: values[name] for name in now if now[name] != before.get(name)})


def _refuse(row: Row, existing: RawRow | None, create: bool | None, parts: Sequence[Row]) -> None:
    """Raise InputError if a row may not be written."""
    if create is True and existing is not None:
        raise InputError(f"{row.full_name} is there already", "exists")
    if (create is False or row.TABLE == ROBOT) and existing is None:
        raise InputError(f"there is no {row.full_name}", "unknown_name")
    if why := row.refusal(existing, parts):
        raise InputError(*why)


def _parts(rows: Iterable[Row]) -> dict[tuple[str, KeyTexts], tuple[Row, ...]]:
    """Return the parts of other rows, by those rows' tables and keys."""
    parts: dict[tuple[str, KeyTexts], tuple[Row, ...]] = {}
    for row in rows:
        if row.PART_OF:
            whole = row.PART_OF, _texts(row.key[:1])
            parts[whole] = (*parts.get(whole, ()), row)
    return parts


def _listed(tables: Iterable[str]) -> str:
    return "write " + ", ".join(sorted(tables)) if tables else "write none"


def _changed(
    newer: Iterable[RevisionRow], robot: str, schema: Schema, part_of: Mapping[str, str]
) -> Iterator[tuple[str, KeyTexts]]:
    """Yield table and key, without the robot, of changed rows; a part counts as its whole."""
    for row in newer:
        owned = "robot" in schema.get(row.table, ())
        if not owned or row.row_key[:1] == (robot,):
            own = row.row_key[1:] if owned else row.row_key
            whole = part_of.get(row.table, "")
            yield (whole, own[:1]) if whole else (row.table, own)


def _own(tables: RawTables, row: Row, robot: str) -> dict[KeyTexts, RawRow]:
    """Return the rows of a table, the robot's and shared ones, by their keys without the robot."""
    rows = (values for values in tables.get(row.TABLE, ()) if values.get("robot", robot) == robot)
    return {_texts(values.get(column) for column in row.KEY): values for values in rows}


def _owner(table: str, robot: str, schema: Schema) -> dict[str, str]:
    """Return the column of a row's robot, empty for tables that all robots share."""
    return {"robot": robot} if "robot" in schema[table] else {}


def _texts(key: Iterable[object]) -> KeyTexts:
    return tuple(map(str, key))
