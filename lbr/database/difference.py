"""What a robot's rows differ in from the shipped ones, for `lbr db diff`."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal

from msgspec import Struct

from lbr.database.columns import json_strictly
from lbr.database.reading import ROBOT, RawRow, RawTables
from lbr.database.shipped import shipped
from lbr.database.store import Database
from lbr.database.tables import WRITTEN_BY_LBR
from lbr.messages.rows import shown


class Difference(Struct, frozen=True, kw_only=True):
    """One row that was added, removed or changed; `columns` holds what is shipped and what is here."""

    table: str
    row: str
    change: Literal["added", "removed", "changed"]
    columns: dict[str, tuple[Any, Any]] = {}

    def __str__(self) -> str:
        changes = "; ".join(f"{name}: {shown(old)} -> {shown(new)}" for name, (old, new) in self.columns.items())
        return f"{self.table} '{self.row}' {self.change}" + (f": {changes}" if changes else "")


def differences(
    database: Database, sql: Path | None = None, *, implied: Callable[[str, RawRow], bool] = lambda _table, _row: False
) -> tuple[Difference, ...]:
    """Compare a database's rows with those that a new one has, or `sql` alone, table by table.

    Of a robot that is not there at all, only that is told; of a row that is `implied`, which says no more than what
    holds without it, nothing.
    """
    (before, _), (here, schema) = shipped(sql), database.tables()
    there = {row["name"] for row in here[ROBOT]}
    before = {
        table: [row for row in rows if table == ROBOT or row.get("robot") is None or row["robot"] in there]
        for table, rows in before.items()
    }
    return tuple(
        found for table, key in schema.keys_of.items() for found in _in_table(table, key, before, here, implied)
    )


def _in_table(
    table: str,
    key_of: tuple[str, ...],
    shipped: RawTables,
    here: RawTables,
    implied: Callable[[str, RawRow], bool],
) -> Iterator[Difference]:
    before, after = (
        {tuple(row[name] for name in key_of): row for row in rows.get(table, ())} for rows in (shipped, here)
    )
    for key in {**before, **after}:
        row = "/".join(shown(part) for part in key)
        if key not in after:
            yield Difference(table=table, row=row, change="removed")
        elif key not in before:
            if implied(table, after[key]):
                continue
            yield Difference(table=table, row=row, change="added")
        elif columns := _changed(table, before[key], after[key]):
            yield Difference(table=table, row=row, change="changed", columns=columns)


def _changed(table: str, before: RawRow, after: RawRow) -> dict[str, tuple[Any, Any]]:
    return {
        column: (old, after[column])
        for column, old in before.items()
        if (table, column) not in WRITTEN_BY_LBR and not _same(old, after[column])
    }


def _same(old: Any, new: Any) -> bool:
    """Say whether two values mean the same; JSON does not care for spaces and the order of keys."""
    if old == new or not (isinstance(old, str) and isinstance(new, str) and old[:1] in "{[" and new[:1] in "{["):
        return bool(old == new)
    try:
        return bool(json_strictly(old) == json_strictly(new))
    except (ValueError, RecursionError):
        return False
