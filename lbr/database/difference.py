"""The differences of rows, for people. Pure."""

from typing import Any, Literal

from msgspec import Struct

from lbr.database.columns import json_strictly
from lbr.database.reading import RawRow
from lbr.database.tables import WRITTEN_BY_LBR
from lbr.messages.rows import short


class Difference(Struct, frozen=True, kw_only=True):
    """One row that was added, removed or changed; `columns` has the old and the new value of each changed one."""

    table: str
    row: str
    change: Literal["added", "removed", "changed"]
    columns: dict[str, tuple[Any, Any]] = {}

    def __str__(self) -> str:
        changes = "; ".join(f"{name}: {short(old)} -> {short(new)}" for name, (old, new) in self.columns.items())
        return f"{self.table} '{self.row}' {self.change}" + (f": {changes}" if changes else "")


def changed_columns(table: str, before: RawRow, after: RawRow) -> dict[str, tuple[object, object]]:
    """Return the changed columns of a row, with old and new values; columns that lbr writes do not count."""
    return {
        column: (old, after.get(column))
        for column, old in before.items()
        if (table, column) not in WRITTEN_BY_LBR and not same(old, after.get(column))
    }


def same(a: object, b: object) -> bool:
    """Return whether two values mean the same; in JSON, spaces and the order of keys do not count."""
    if a == b or not (isinstance(a, str) and isinstance(b, str) and a[:1] in "{[" and b[:1] in "{["):
        return bool(a == b)
    try:
        return _alike(json_strictly(a), json_strictly(b))
    except (ValueError, RecursionError):
        return False


def _alike(a: object, b: object) -> bool:
    """Return whether two values of JSON are the same; `true` is not 1."""
    if isinstance(a, bool) or isinstance(b, bool):
        return a is b
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(_alike(value, b[name]) for name, value in a.items())
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(_alike, a, b))
    return bool(a == b)
