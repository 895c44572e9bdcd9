"""Changes of rows from forms: the tables after them, or the reason against them. Pure."""

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
from lbr.messages.rows import Key, Row, short

Classes = Mapping[str, type[Row]]
NAMES_PROGRAMS = "names a program, and a page changes none: edit it with an SQLite client at the robot"
PROGRAM_KIND = "exec"
"""The kind whose rows name a program to run."""


class ChangedError(InputError):
    """A row was changed or deleted after the form read it. The error has its table and key."""

    def __init__(self, text: str, table: str, key: tuple[object, ...]) -> None:
        super().__init__(text, "changed")
        self.table = table
        self.key = key


def fixed(row: type[Row]) -> str:
    """Return why a page may not change a table at all, or an empty text."""
    return f"a row of {row.TABLE} {NAMES_PROGRAMS}" if row is ExternalCommandRow else ""


def schema(row: type[Row]) -> dict[str, object]:
    """Return the JSON Schema of a table's rows, with the meaning of each column."""
    whole = msgspec.json.schema(row)
    for name, column in columns(row).items():
        whole["$defs"][row.__name__]["properties"][name]["description"] = column.meaning
    return whole


def json_row(row: type[Row], values: RawRow) -> dict[str, object]:
    """Return a row as in JSON, without its robot. A bad value stays as it is in the table."""
    return {name: _json_value(column, values.get(name)) for name, column in columns(row).items()}


def wanted(robot: str, forms: Sequence[RowChange], classes: Classes) -> Wanted:
    """Return a function for the changes of forms. It raises ChangedError for a row that others changed."""
    return lambda tables, schema: changes.between(tables, changed(tables, schema, robot, forms, classes), schema)


def undoing(before: RawTables, after: RawTables, schema: Schema, classes: Classes) -> list[RowChange]:
    """Return the forms that undo a change, only for the changed columns."""
    return [_form(of(one.table, schema, classes), one) for one in changes.between(after, before, schema)]


def changed(tables: RawTables, schema: Schema, robot: str, forms: Sequence[RowChange], classes: Classes) -> RawTables:
    """Return the tables after some changes. InputError names the row in the way, with the reason."""
    after: dict[str, Sequence[RawRow]] = dict(tables)
    for change in forms:
        row = _class_of(change, schema, classes)
        key = _key(row, change)
        existing = next((each for each in after.get(row.TABLE, ()) if _is(each, row, schema, robot, key)), None)
        _compare(row, key, existing, change)
        _allow(row, key, existing, change)
        rest = [each for each in after.get(row.TABLE, ()) if each is not existing]
        after[row.TABLE] = rest if change.after is None else [*rest, _raw(row, schema, robot, existing, change.after)]
    return after


def of(table: str, schema: Schema, classes: Classes) -> type[Row]:
    """Return the class of a table's rows; raise InputError if no such table has revisions."""
    known = sorted(name for name in classes if name in schema)
    if table not in known:
        raise InputError(f"there is no table '{short(table)}': {', '.join(known)}", "unknown_name")
    return classes[table]


def _form(row: type[Row], change: changes.Change) -> RowChange:
    was = None if change.before is None else json_row(row, change.before)
    then = None if change.after is None else json_row(row, change.after)
    if was is not None and then is not None:
        names = [name for name in then if name in row.KEY or then[name] != was[name]]
        was, then = {name: was[name] for name in names}, {name: then[name] for name in names}
    return RowChange(table=row.TABLE, before=was, after=then)


def _class_of(change: RowChange, schema: Schema, classes: Classes) -> type[Row]:
    row = of(change.table, schema, classes)
    if change.before is None and change.after is None:
        raise InputError(f"a change of {row.TABLE} has neither an old nor a new row")
    if why := fixed(row):
        raise InputError(why, "denied")
    return row


def _key(row: type[Row], change: RowChange) -> Key:
    """Return the key of the row to change. An existing row keeps its key."""
    before, after = change.before, change.after
    given: Mapping[str, Any] = before if before is not None else after or {}
    if missing := [name for name in row.KEY if name not in given]:
        raise InputError(f"a row of {row.TABLE} needs {' and '.join(missing)}")
    if unknown := [name for values in (before, after) for name in values or () if name not in columns(row)]:
        raise InputError(f"{row.TABLE} has no column '{short(unknown[0])}'", "unknown_name")
    key = tuple(given[name] for name in row.KEY)
    if any((after or given).get(name, value) != value for name, value in zip(row.KEY, key, strict=True)):
        raise InputError(f"{_named(row, key)} keeps its {' and '.join(row.KEY)}: add another row, and delete this one")
    return key


def _is(values: RawRow, row: type[Row], schema: Schema, robot: str, key: tuple[object, ...]) -> bool:
    mine = row.TABLE == ROBOT or "robot" not in schema[row.TABLE] or values["robot"] == robot
    return mine and tuple(values[name] for name in row.KEY) == key


def _compare(row: type[Row], key: tuple[object, ...], existing: RawRow | None, change: RowChange) -> None:
    """Raise InputError if the row was changed after the form read it."""
    before = change.before
    if before is None:
        if existing is not None:
            raise InputError(f"{_named(row, key)} is there already", "exists")
        return
    if existing is None:
        raise ChangedError(f"{_named(row, key)} was deleted meanwhile", row.TABLE, key)
    now = json_row(row, existing)
    if others := [name for name, value in before.items() if now.get(name) != value]:
        raise ChangedError(f"{_named(row, key)} was changed meanwhile: {', '.join(others)}", row.TABLE, key)


def _allow(row: type[Row], key: tuple[object, ...], existing: RawRow | None, change: RowChange) -> None:
    """Raise InputError for a change that pages may not make."""
    after = change.after or {}
    if row.TABLE == ROBOT:
        if change.after is None or change.before is None:
            raise InputError("a page makes and deletes no robot", "denied")
        if others := [
            name for name in after if (ROBOT, name) in WRITTEN_BY_LBR and after[name] != change.before.get(name)
        ]:
            raise InputError(f"{', '.join(others)} of the robot is written by lbr itself", "read_only")
    if row is CapabilityRow and PROGRAM_KIND in {(existing or {}).get("kind"), after.get("kind")}:
        raise InputError(f"{_named(row, key)} {NAMES_PROGRAMS}", "denied")


def _raw(row: type[Row], schema: Schema, robot: str, existing: RawRow | None, after: Mapping[str, object]) -> RawRow:
    values: dict[str, Any] = dict(existing) if existing is not None else _defaults(row)
    if existing is None and "robot" in schema[row.TABLE]:
        values = {"robot": robot, **values}
    of_row = columns(row)
    for name, value in after.items():
        if existing is None or _json_value(of_row[name], existing.get(name)) != value:
            values[name] = _stored(of_row[name], value)
    return values


def _defaults(row: type[Row]) -> dict[str, object]:
    return {name: one.write(one.stand_in) for name, one in columns(row).items() if not one.field.required}


def _json_value(column: Column, value: object) -> object:
    if column.holds_json and isinstance(value, str):
        try:
            return json_strictly(value)
        except (ValueError, RecursionError):
            return value
    return bool(value) if column.is_flag and value in (0, 1) else value


def _stored(column: Column, value: object) -> object:
    """Return a value for SQLite. The check of all rows reports a bad value beside its column."""
    if column.holds_json and value is not None:
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool) and column.is_flag:
        return int(value)
    return value if isinstance(value, str | int | float | None) and not isinstance(value, bool) else json.dumps(value)


def _named(row: type[Row], key: Iterable[object]) -> str:
    return f"{row.TABLE} '{short('/'.join(map(str, key)))}'"
