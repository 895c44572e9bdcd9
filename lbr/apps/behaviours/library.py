"""The robot's tables, compiled from its rows; edits, and tables of pages, are checked against them."""

from collections.abc import Iterable, Mapping
from typing import TypeVar

import msgspec
from msgspec.structs import replace

from lbr.apps.behaviours import files, outputs, texts
from lbr.apps.behaviours.kind import BehaviourSettings
from lbr.apps.behaviours.senses import Senses
from lbr.apps.behaviours.table import (
    MOST_FAULTS,
    Compiled,
    Fault,
    Parts,
    Table,
    cell_faults,
    compile_table,
    compiled_alone,
    linked,
)
from lbr.capability.context import Context
from lbr.errors import InputError
from lbr.messages.behaviour import (
    BehaviourChecked,
    BehaviourFault,
    BehaviourRow,
    BehaviourState,
    BehaviourSummary,
    BehaviourTable,
    BehaviourTables,
    ReadBehaviour,
    WriteBehaviour,
)
from lbr.messages.rows import Row, RowsChanged
from lbr.messages.sensing import RING, RangeSensor
from lbr.messages.unreadable import UNREADABLE

R = TypeVar("R", bound=Row)


class Library:
    """All tables of a robot: `compile` makes them, `follow` applies an edit of the rows."""

    def __init__(self, ctx: Context[BehaviourSettings], senses: Senses) -> None:
        self._ctx = ctx
        self._senses = senses
        self._tables: dict[str, BehaviourTable] = {row.name: row for row in ctx.rows(BehaviourTable)}
        self._rows: tuple[BehaviourRow, ...] = ctx.rows(BehaviourRow)
        self._sensors: tuple[RangeSensor, ...] = ctx.rows(RangeSensor)
        self._compiled: dict[str, Compiled] = {}

    def follow(self, message: RowsChanged) -> None:
        """Apply an edit of the rows, and compile."""
        self._tables = {row.name: row for row in _edited(BehaviourTable, self._tables.values(), message)}
        self._rows = tuple(_edited(BehaviourRow, self._rows, message))
        self._sensors = tuple(_edited(RangeSensor, self._sensors, message))
        self.compile()

    def compile(self) -> None:
        """Compile all tables, and publish their names and faults."""
        self._compiled = linked(compiled_alone(self._tables.values(), self._rows, self._parts()))
        summaries = (
            BehaviourSummary(
                name=name,
                help=self._tables[name].help,
                rows=len(self._rows_of(name)),
                faults=_report(compiled.faults),
            )
            for name, compiled in self._compiled.items()
        )
        self._ctx.publish("tables", BehaviourTables(tables=tuple(summaries)))

    def good(self) -> dict[str, Table]:
        """Return the tables that can be run, by name."""
        return {name: one.table for name, one in self._compiled.items() if one.table is not None}

    def refusal(self, name: str) -> str:
        """Return why a table cannot be run; empty if it can, or does not exist."""
        one = self._compiled.get(name)
        return texts.faults(name, one.errors) if one is not None and one.table is None else ""

    def runnable(self, name: str) -> Table:
        """Return a table; raise InputError if it does not exist or has faults."""
        self._require(name)
        if why := self.refusal(name):
            raise InputError(why, "bad_value")
        return self.good()[name]

    def reachable(self, table: Table) -> list[Table]:
        """Return a table and all that it can run."""
        good, tables = self.good(), {table.name: table}
        waiting = [table]
        while waiting:
            for name in waiting.pop().calls:
                if name in good and name not in tables:
                    tables[name] = good[name]
                    waiting.append(good[name])
        return list(tables.values())

    def faults(
        self, name: str, rows: Iterable[BehaviourRow], lines: Mapping[int, int] | None = None
    ) -> tuple[BehaviourFault, ...]:
        """Return the faults that a table of these rows would have beside the robot's others."""
        table = self._tables.get(name) or BehaviourTable(name=name)
        mine = [row if row.behaviour == name else replace(row, behaviour=name) for row in rows]
        return _report(linked({**self._compiled, name: compile_table(table, mine, self._parts())})[name].faults, lines)

    def read(self, message: ReadBehaviour) -> BehaviourChecked:
        """Return the rows and faults of a file; without rows if a cell cannot be read."""
        file = files.read(message.content, message.name, json=message.file.lower().endswith(".json"))
        if file.faults:
            faults = tuple(BehaviourFault(line=each.line, column=each.column, text=each.text) for each in file.faults)
            more = _report(cell_faults(file.rows, self._parts()), file.lines)
            return BehaviourChecked(accepted=True, faults=(*faults, *more))
        faults = self.faults(message.name, file.rows, file.lines)
        return BehaviourChecked(accepted=True, faults=faults, rows=file.rows)

    def written(self, message: WriteBehaviour) -> bytes:
        """Return a table as a file; raise InputError if it does not exist."""
        self._require(message.name)
        rows = self._rows_of(message.name)
        if message.form == "json":
            return files.to_json(rows)
        return files.to_csv(rows, ";" if message.form == "semicolons" else ",").encode("utf-8-sig")

    def listed(self, now: BehaviourState) -> str:
        """Return all tables as text; the running one is marked."""
        return texts.listed(self._tables, self._compiled, now)

    def drawing(self, name: str, at: str) -> str:
        """Draw a table as text, with the robot at state `at`; raise InputError if it does not exist."""
        self._require(name)
        return texts.graph(self._tables[name], self._rows_of(name), at)

    def _rows_of(self, name: str) -> list[BehaviourRow]:
        return [row for row in self._rows if row.behaviour == name]

    def _parts(self) -> Parts:
        """Return the parts of this robot."""
        asks = frozenset(way for way in outputs.NEEDS if self._ctx.targets(way))
        return Parts(self._senses.streams, asks, frozenset(row.name for row in self._sensors) or frozenset(RING))

    def _require(self, name: str) -> None:
        """Raise InputError if there is no such table."""
        if name not in self._tables:
            there = ", ".join(sorted(self._tables)) or "none"
            raise InputError(f"there is no behaviour '{name}': there is {there}", "unknown_name")


def _report(faults: Iterable[Fault], lines: Mapping[int, int] | None = None) -> tuple[BehaviourFault, ...]:
    """Return the first faults as messages."""
    return tuple(
        BehaviourFault(
            step=one.step, line=(lines or {}).get(one.step, 0), column=one.column, text=one.text, error=one.error
        )
        for one in list(faults)[:MOST_FAULTS]
    )


def _edited(row: type[R], before: Iterable[R], message: RowsChanged) -> list[R]:
    """Return the rows of a table after an edit."""
    try:
        removed = set(msgspec.json.decode(message.gone.get(row.TABLE, "[]"), type=list[tuple[object, ...]]))
        told = msgspec.json.decode(message.rows.get(row.TABLE, "[]"), type=list[object])
        added = [msgspec.convert(each, row) for each in told]
    except (TypeError, *UNREADABLE) as err:
        raise InputError(f"rows of {row.TABLE} cannot be read: {err}", "malformed") from err
    found = {each.key: each for each in before if each.key not in removed}
    return list((found | {each.key: each for each in added}).values())
