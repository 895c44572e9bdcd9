"""The triggers that keep each change of a table's rows as a revision: one form, generated from the columns. Pure."""

from collections.abc import Iterable, Sequence
from textwrap import wrap

WIDTH = 120
_JOINT = "\0"
"""A blank at which no line ends."""
_KEEPS = """BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('{table}', {key}, '{operation}',
            {old},
            {new});
END;
"""


def revision_triggers(table: str, columns: Sequence[str], key: Sequence[str]) -> str:
    """Return the SQL of the three triggers of a table: `columns` are kept, `key` identifies its rows."""
    before, after = (_whole(row, columns) for row in ("OLD", "NEW"))
    changed = f"WHEN {_list('OLD', columns)}\n     IS NOT {_list('NEW', columns)}\n"
    return "\n".join(
        (
            _trigger(table, "insert", "", _key("NEW", key), "NULL", after),
            _trigger(table, "update", changed, _key("NEW", key), before, after),
            _trigger(table, "delete", "", _key("OLD", key), before, "NULL"),
        )
    )


def _trigger(table: str, operation: str, when: str, key: str, old: str, new: str) -> str:
    head = f"CREATE TRIGGER {table}_{operation} AFTER {operation.upper()} ON {table}\n{when}"
    return head + _KEEPS.format(table=table, key=key, operation=operation, old=old, new=new)


def _key(row: str, key: Iterable[str]) -> str:
    return f"json_array({', '.join(f'{row}.{name}' for name in key)})"


def _whole(row: str, columns: Iterable[str]) -> str:
    pairs = [f"'{name}',{_JOINT}{row}.{name}" for name in columns]
    return _wrapped(f"json_object({', '.join(pairs)})", 12)


def _list(row: str, columns: Iterable[str]) -> str:
    return _wrapped(f"({', '.join(f'{row}.{name}' for name in columns)})", 5)


def _wrapped(text: str, indent: int) -> str:
    """Return a text wrapped to a width, with further lines indented."""
    lines = wrap(text, WIDTH - indent - 8, break_long_words=False, break_on_hyphens=False)
    return f"\n{' ' * indent}".join(lines).replace(_JOINT, " ")
