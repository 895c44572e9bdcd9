"""The robot's tables, compiled from its rows; edits, and tables of pages, are checked against them."""

from collections.abc import Iterable, Mapping

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
from lbr.messages.sensing import RING, RangeSensor


class Library:
    """All tables of a robot; `compile` makes them, again after an edit of the rows."""

    def __init__(self, ctx: Context[BehaviourSettings], senses: Senses) -> None:
        self._ctx = ctx
        self._senses = senses
        self._compiled: dict[str, Compiled] = {}
        self._rows = self._read_rows()

    def _read_rows(self) -> tuple[tuple[BehaviourTable, ...], tuple[BehaviourRow, ...], tuple[RangeSensor, ...]]:
        return self._ctx.rows(BehaviourTable), self._ctx.rows(BehaviourRow), self._ctx.rows(RangeSensor)

    @property
    def _tables(self) -> dict[str, BehaviourTable]:
        return {row.name: row for row in self._ctx.rows(BehaviourTable)}

    @property
    def is_edited(self) -> bool:
        """Return whether the rows are others than those that are compiled."""
        return self._rows != self._read_rows()

    def compile(self) -> None:
        """Compile all tables, and publish their names and faults."""
        self._rows = self._read_rows()
        self._compiled = linked(compiled_alone(*self._rows[:2], self._parts()))
        tables = self._tables
        summaries = (
            BehaviourSummary(
                name=name,
                help=tables[name].help,
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
        return [row for row in self._ctx.rows(BehaviourRow) if row.behaviour == name]

    def _parts(self) -> Parts:
        """Return the parts of this robot."""
        asks = frozenset(way for way in outputs.NEEDS if self._ctx.targets(way))
        return Parts(
            self._senses.streams, asks, frozenset(row.name for row in self._ctx.rows(RangeSensor)) or frozenset(RING)
        )

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
