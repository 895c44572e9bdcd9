"""The differences of rows, as people read them. Pure."""

from typing import Any, Literal

from msgspec import Struct

from lbr.database.columns import json_strictly
from lbr.database.reading import RawRow
from lbr.database.tables import WRITTEN_BY_LBR
from lbr.messages.rows import shown


class Difference(Struct, frozen=True, kw_only=True):
    """One row that was added, removed or changed; `columns` holds what was and what is, of each that differs."""

    table: str
    row: str
    change: Literal["added", "removed", "changed"]
    columns: dict[str, tuple[Any, Any]] = {}

    def __str__(self) -> str:
        changes = "; ".join(f"{name}: {shown(old)} -> {shown(new)}" for name, (old, new) in self.columns.items())
        return f"{self.table} '{self.row}' {self.change}" + (f": {changes}" if changes else "")


def changed_columns(table: str, before: RawRow, after: RawRow) -> dict[str, tuple[Any, Any]]:
    """Return the columns of a row that differ, with what was and what is; what lbr itself writes is no difference."""
    return {
        column: (old, after.get(column))
        for column, old in before.items()
        if (table, column) not in WRITTEN_BY_LBR and not same(old, after.get(column))
    }


def same(old: object, new: object) -> bool:
    """Say whether two values mean the same; JSON does not care for spaces and the order of keys."""
    if old == new or not (isinstance(old, str) and isinstance(new, str) and old[:1] in "{[" and new[:1] in "{["):
        return bool(old == new)
    try:
        return _alike(json_strictly(old), json_strictly(new))
    except (ValueError, RecursionError):
        return False


def _alike(old: object, new: object) -> bool:
    """Say whether two values of JSON are the same; `true` is no 1."""
    if isinstance(old, bool) or isinstance(new, bool):
        return old is new
    if isinstance(old, dict) and isinstance(new, dict):
        return old.keys() == new.keys() and all(_alike(value, new[name]) for name, value in old.items())
    if isinstance(old, list) and isinstance(new, list):
        return len(old) == len(new) and all(map(_alike, old, new))
    return bool(old == new)
