"""Changes of rows as people make them in forms: what they make of the tables, and why not. Pure."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec

from lbr.database import changes
from lbr.database.columns import Column, columns, json_strictly
from lbr.database.proposals import Wanted
from lbr.database.reading import ROBOT, RawRow, RawTables
from lbr.database.rows import CapabilityRow, ExternalCommandRow
from lbr.database.tables import WRITTEN_BY_LBR, Schema
from lbr.errors import InputError
from lbr.messages.manage import RowChange
from lbr.messages.rows import Row, shown

Classes = Mapping[str, type[Row]]
NAMES_PROGRAMS = "names a program, and a page changes none: edit it with an SQLite client at the robot"
PROGRAM_KIND = "exec"
"""The kind whose rows say which program runs."""


class ChangedError(InputError):
    """A row is not any more as it was when it was looked at: which one, by its table and what names it."""

    def __init__(self, text: str, table: str, key: tuple[Any, ...]) -> None:
        super().__init__(text, "changed")
        self.table = table
        self.key = key


def fixed(row: type[Row]) -> str:
    """Return why a page may not change a table at all, or nothing."""
    return f"a row of {row.TABLE} {NAMES_PROGRAMS}" if row is ExternalCommandRow else ""


def schema(row: type[Row]) -> dict[str, Any]:
    """Return the JSON Schema of a table's rows, with what each column means."""
    whole = msgspec.json.schema(row)
    for name, column in columns(row).items():
        whole["$defs"][row.__name__]["properties"][name]["description"] = column.meaning
    return whole


def told(row: type[Row], values: RawRow) -> dict[str, Any]:
    """Return a row as JSON has it, without whose it is; what cannot be read stands as it is in the table."""
    return {name: _told(column, values.get(name)) for name, column in columns(row).items()}


def wanted(robot: str, forms: Sequence[RowChange], classes: Classes) -> Wanted:
    """Return what forms want of a robot's rows; ChangedError if one is not as it was when it was looked at."""
    return lambda tables, schema: changes.between(tables, changed(tables, schema, robot, forms, classes), schema)


def changed(tables: RawTables, schema: Schema, robot: str, forms: Sequence[RowChange], classes: Classes) -> RawTables:
    """Return the tables as they are after some changes; InputError says which row is in the way, and why."""
    after: dict[str, Sequence[RawRow]] = dict(tables)
    for change in forms:
        row = _class_of(change, schema, classes)
        key = _key(row, change)
        there = next((one for one in after.get(row.TABLE, ()) if _is(one, row, schema, robot, key)), None)
        _compare(row, key, there, change)
        _allow(row, key, there, change)
        rest = [one for one in after.get(row.TABLE, ()) if one is not there]
        after[row.TABLE] = rest if change.after is None else [*rest, _raw(row, schema, robot, there, change.after)]
    return after


def of(table: str, schema: Schema, classes: Classes) -> type[Row]:
    """Return what a table's rows are; InputError if there is no such table, or none whose changes are kept."""
    known = sorted(name for name in classes if name in schema)
    if table not in known:
        raise InputError(f"there is no table '{shown(table)}': {', '.join(known)}", "unknown_name")
    return classes[table]


def _class_of(change: RowChange, schema: Schema, classes: Classes) -> type[Row]:
    row = of(change.table, schema, classes)
    if change.before is None and change.after is None:
        raise InputError(f"a change of {row.TABLE} says neither what was nor what is to be")
    if why := fixed(row):
        raise InputError(why, "denied")
    return row


def _key(row: type[Row], change: RowChange) -> tuple[Any, ...]:
    """Return which row is meant; one that is changed keeps its name."""
    old, new = change.before, change.after
    said: Mapping[str, Any] = old if old is not None else new or {}
    if missing := [name for name in row.KEY if name not in said]:
        raise InputError(f"a row of {row.TABLE} needs {' and '.join(missing)}")
    if unknown := [name for one in (old, new) for name in one or () if name not in columns(row)]:
        raise InputError(f"{row.TABLE} has no column '{shown(unknown[0])}'", "unknown_name")
    key = tuple(said[name] for name in row.KEY)
    if old is not None and new is not None and any(new.get(name, old[name]) != old[name] for name in row.KEY):
        raise InputError(f"{_named(row, key)} keeps its {' and '.join(row.KEY)}: add another row, and delete this one")
    return key


def _is(values: RawRow, row: type[Row], schema: Schema, robot: str, key: tuple[Any, ...]) -> bool:
    mine = row.TABLE == ROBOT or "robot" not in schema[row.TABLE] or values["robot"] == robot
    return mine and tuple(values[name] for name in row.KEY) == key


def _compare(row: type[Row], key: tuple[Any, ...], there: RawRow | None, change: RowChange) -> None:
    """Raise InputError if the row is not as it was when it was looked at."""
    before = change.before
    if before is None:
        if there is not None:
            raise InputError(f"{_named(row, key)} is there already", "exists")
        return
    if there is None:
        raise ChangedError(f"{_named(row, key)} was deleted meanwhile", row.TABLE, key)
    now = told(row, there)
    if others := [name for name, value in before.items() if now.get(name) != value]:
        raise ChangedError(f"{_named(row, key)} was changed meanwhile: {', '.join(others)}", row.TABLE, key)


def _allow(row: type[Row], key: tuple[Any, ...], there: RawRow | None, change: RowChange) -> None:
    """Raise InputError for what no page may change."""
    after = change.after or {}
    if row.TABLE == ROBOT:
        if change.after is None or change.before is None:
            raise InputError("a page makes and deletes no robot", "denied")
        if others := [
            name for name in after if (ROBOT, name) in WRITTEN_BY_LBR and after[name] != change.before.get(name)
        ]:
            raise InputError(f"{', '.join(others)} of the robot is written by lbr itself", "read_only")
    if row is CapabilityRow and PROGRAM_KIND in {(there or {}).get("kind"), after.get("kind")}:
        raise InputError(f"{_named(row, key)} {NAMES_PROGRAMS}", "denied")


def _raw(row: type[Row], schema: Schema, robot: str, there: RawRow | None, after: Mapping[str, Any]) -> RawRow:
    values: dict[str, Any] = dict(there) if there is not None else _defaults(row)
    if there is None and "robot" in schema[row.TABLE]:
        values = {"robot": robot, **values}
    of_row = columns(row)
    for name, value in after.items():
        if there is None or _told(of_row[name], there.get(name)) != value:
            values[name] = _stored(of_row[name], value)
    return values


def _defaults(row: type[Row]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for field in msgspec.structs.fields(row):
        if field.default is not msgspec.NODEFAULT:
            found[field.name] = columns(row)[field.name].write(field.default)
        elif field.default_factory is not msgspec.NODEFAULT:
            found[field.name] = columns(row)[field.name].write(field.default_factory())
    return found


def _told(column: Column, value: Any) -> Any:
    if column.holds_json and isinstance(value, str):
        try:
            return json_strictly(value)
        except (ValueError, RecursionError):
            return value
    return bool(value) if column.is_flag and value in (0, 1) else value


def _stored(column: Column, value: Any) -> Any:
    """Return what SQLite is to hold; what is wrong with it the check of all rows says, beside the column."""
    if column.holds_json and value is not None:
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool) and column.is_flag:
        return int(value)
    return value if isinstance(value, str | int | float | None) and not isinstance(value, bool) else json.dumps(value)


def _named(row: type[Row], key: Iterable[Any]) -> str:
    return f"{row.TABLE} '{shown('/'.join(map(str, key)))}'"
