"""Tables for SQLAlchemy, from the classes of their rows; and as SQL, for people.

class Joint(Row): … ── metadata ──► Table ── text, revision_triggers ──► robot.db.sql, steps of an upgrade
                                          └─ differences, by Alembic ──► what a database has otherwise

Reading rows needs none of this module: SQLAlchemy takes long to load.
"""

import sqlite3
from collections.abc import Iterable, Sequence
from textwrap import wrap
from typing import Any

from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from msgspec import inspect
from sqlalchemy import REAL, CheckConstraint, ForeignKeyConstraint, Integer, MetaData, Table, Text, create_engine, sql
from sqlalchemy import Column as SqlColumn
from sqlalchemy.pool import StaticPool

from lbr.database import triggers
from lbr.database.columns import Column, columns
from lbr.messages import shapes
from lbr.messages.rows import Row
from lbr.messages.shapes import Shape


def metadata(rows: Iterable[type[Row]]) -> MetaData:
    """Return the tables of these rows."""
    known = MetaData()
    for row in rows:
        whole = row.whole()
        table = Table(row.TABLE, known, comment=" ".join((row.__doc__ or "").partition("\n\n")[0].split()))
        if not row.SHARED:
            table.append_column(SqlColumn("robot", Text, primary_key=True, nullable=False, comment="its robot"))
        for name, column in columns(row).items():
            is_part = bool(whole) and name == row.KEY[0]
            table.append_column(_column(name, column, key=name in row.KEY, checked=not is_part))
        if whole:
            table.append_constraint(_goes_with(("robot", row.KEY[0]), (f"{whole}.robot", f"{whole}.name")))
        elif not row.SHARED:
            table.append_constraint(_goes_with(("robot",), ("robot.name",)))
        for lower, higher in row.ASCENDING:
            table.append_constraint(CheckConstraint(shapes.ASCENDING.check(higher, y=lower)))
        for one, other in row.TOGETHER:
            table.append_constraint(CheckConstraint(shapes.TOGETHER.check(other, y=one)))
    return known


def text(table: Table) -> str:
    """Return the readable SQL that makes a table."""
    name = max(len(column.name) for column in table.columns)
    kind = max(len(str(column.type)) for column in table.columns)
    key = [column.name for column in table.primary_key]
    over = over_all(table)[0 if len(key) > 1 else 1 :]
    last = None if over else [*table.columns][-1]
    lines = [
        _line(column, name, kind, "" if column is last else ",", key=key == [column.name]) for column in table.columns
    ]
    introduction = wrap(str(table.comment), triggers.WIDTH - 3, break_long_words=False, break_on_hyphens=False)
    begin = "".join(f"-- {line}\n" for line in introduction)
    body = "\n    ".join([*lines, ",\n    ".join(over)] if over else lines)
    return f"{begin}CREATE TABLE {table.name} (\n    {body}\n) STRICT;\n"


def script(row: type[Row]) -> str:
    """Return the SQL that makes the table of a user's own kind, with its triggers."""
    table = metadata([row]).tables[row.TABLE]
    return f"{text(table)}\n{revision_triggers(table)}"


def over_all(table: Table) -> list[str]:
    """Return the rules over more than one column: the keys and the checks."""
    constraints = [f"PRIMARY KEY ({', '.join(column.name for column in table.primary_key)})"]
    for own in table.foreign_key_constraints:
        targets = [element.target_fullname.partition(".") for element in own.elements]
        refers = f"{targets[0][0]} ({', '.join(name for _, _, name in targets)})"
        keys = ", ".join(own.column_keys)
        constraints.append(f"FOREIGN KEY ({keys}) REFERENCES {refers} ON UPDATE CASCADE ON DELETE CASCADE")
    checks = [one for one in table.constraints if isinstance(one, CheckConstraint) and "of" not in one.info]
    return constraints + sorted(f"CHECK ({check.sqltext})" for check in checks)


def revision_triggers(table: Table) -> str:
    """Return the SQL of the triggers that record changes of a table's rows, but not of columns that lbr writes."""
    kept = [column.name for column in table.columns if not column.info.get("by_lbr")]
    return triggers.revision_triggers(table.name, kept, [column.name for column in table.primary_key])


def differences(connection: sqlite3.Connection, known: MetaData) -> list[object]:
    """Return the differences of a database from these tables, by Alembic."""
    engine = create_engine("sqlite://", creator=lambda: connection, poolclass=StaticPool)
    with engine.connect() as opened:
        return list(compare_metadata(MigrationContext.configure(opened, opts={"compare_server_default": True}), known))


def _goes_with(columns: Sequence[str], others: Sequence[str]) -> ForeignKeyConstraint:
    return ForeignKeyConstraint(columns, others, onupdate="CASCADE", ondelete="CASCADE")


def _column(name: str, column: Column, *, key: bool, checked: bool) -> SqlColumn[Any]:
    check, allowed = "", ""
    if checked and (found := _shape(column)):
        shape, bounds = found
        check = shape.check(name, **bounds)
        allowed = (shape.allowed(check) or ("", ""))[1] + ", or NULL" * column.nullable
        if column.nullable:
            check = f"{name} IS NULL OR ({check})"
    default = _default(column)
    return SqlColumn(
        name,
        _type(column),
        *([CheckConstraint(check, info={"of": name})] if check else []),
        primary_key=key,
        nullable=column.nullable,
        server_default=None if default is None else sql.text(default),
        comment=column.meaning,
        info={**column.extra, "check": check, "allowed": allowed},
    )


def _type(column: Column) -> type[Any]:
    info = column.info
    if column.is_flag or isinstance(info, inspect.IntType):
        return Integer
    if isinstance(info, inspect.LiteralType) and isinstance(info.values[0], int):
        return Integer
    return REAL if isinstance(info, inspect.FloatType) else Text


def _default(column: Column) -> str | None:
    """Return a column's default as SQL; None if it is NULL, or if the column has no default."""
    if "default" in column.extra:
        return column.extra["default"]  # type: ignore[no-any-return]
    if column.field.required or "counted" in column.extra:
        return None
    value = column.write(column.stand_in)
    return None if value is None else f"{value:g}" if isinstance(value, float) else repr(value)


def _shape(column: Column) -> tuple[Shape, dict[str, str]] | None:
    """Return the shape and bounds of a column's values; None if any value of its type is valid."""
    info = column.info
    if "shape" in column.extra:
        return column.extra["shape"], {}
    if column.is_flag or isinstance(info, inspect.LiteralType):
        values = (0, 1) if column.is_flag else column.choices()
        return shapes.ONE_OF, {"list": ", ".join(map(repr, values))}
    if column.is_json:
        return (shapes.OBJECT if isinstance(info, inspect.DictType) else shapes.LIST), {}
    if column.is_text:
        return _bounded(info.min_length, info.max_length, shapes.LENGTH, shapes.LONGER, shapes.SHORTER)
    if info.gt is not None:
        return _bounded(info.gt, info.le, shapes.ABOVE, shapes.ABOVE, shapes.WITHIN)
    return _bounded(info.ge, info.le, shapes.WITHIN, shapes.AT_LEAST, shapes.WITHIN)


def _bounded(low: Any, high: Any, both: Shape, least: Shape, most: Shape) -> tuple[Shape, dict[str, str]] | None:
    bounds = {name: _number(bound) for name, bound in (("a", low), ("b", high)) if bound is not None}
    return (both if len(bounds) > 1 else least if "a" in bounds else most, bounds) if bounds else None


def _number(bound: float) -> str:
    return str(int(bound)) if abs(bound) < 2**53 and bound == int(bound) else repr(bound)


def _line(column: SqlColumn[object], name: int, kind: int, comma: str, *, key: bool) -> str:
    rules = [
        "" if column.nullable else "NOT NULL",
        "PRIMARY KEY" + " AUTOINCREMENT" * ("counted" in column.info) if key else "",
        f"DEFAULT {default_of(column)}" if column.server_default is not None else "",
    ]
    line = f"{column.name:<{name}} {column.type!s:<{kind}} {' '.join(filter(None, rules))}".rstrip()
    if check := column.info.get("check"):
        return f"{line}  -- {comment(column)}\n        CHECK ({check}){comma}"
    return f"{line}{comma}  -- {comment(column)}"


def comment(column: SqlColumn[Any]) -> str:
    """Return the meaning of a column, and the form of its values."""
    check = column.info.get("check", "")
    form = "JSON object: " if "= 'object'" in check else "JSON list: " if "= 'array'" in check else ""
    return form + str(column.comment) + "; written by lbr" * ("by_lbr" in column.info)


def default_of(column: SqlColumn[object]) -> str:
    """Return the default of a column as SQL."""
    return str(column.server_default.arg)  # type: ignore[union-attr]
