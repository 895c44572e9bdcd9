"""The tables of one robot: each is read and checked on request, with all problems of a row at once."""

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeVar, cast

from msgspec import Struct

from lbr.database.columns import WrongError, columns
from lbr.messages.rows import Check, Fault, Others, Row, short

R = TypeVar("R", bound=Row)
RawRow = Mapping[str, Any]
RawTables = Mapping[str, Sequence[RawRow]]
"""Table name to rows, each from column name to SQLite's value."""
ROBOT = "robot"
"""The table of the robots themselves, and the column with a row's robot."""


class Problem(Struct, frozen=True):
    """A problem of one row: `row` is its key, for people; `column` is empty for the whole row."""

    table: str
    row: str
    column: str
    text: str

    def __str__(self) -> str:
        where = f"{self.table} '{self.row}'" if self.row else self.table
        return f"{where}, {self.column}: {self.text}" if self.column else f"{where}: {self.text}"


class _UnreadError(Exception):
    """A check needs an unreadable column, whose fault is already reported."""


class _Partial:
    """A row with unreadable columns."""

    def __init__(self, row: Row, unread: frozenset[str]) -> None:
        self._row = row
        self._unread = unread

    def __getattr__(self, name: str) -> object:
        if name in self._unread or (name == "key" and not self._unread.isdisjoint(self._row.KEY)):
            raise _UnreadError
        return getattr(self._row, name)


class Read(Struct):
    """A row as it was read; its `unread` columns have stand-ins, its `wrong` ones contradict others."""

    label: str
    row: Any
    unread: frozenset[str]
    wrong: set[str]

    @property
    def view(self) -> Any:
        """Return the row for checks."""
        return _Partial(self.row, self.unread) if self.unread else self.row


class Tables:
    """All tables of one robot; a table's rows are read and checked on request."""

    def __init__(self, raw: RawTables, robot: str, columns: Mapping[str, Iterable[str]]) -> None:
        self._raw = raw
        self._robot = robot
        self._columns = columns
        self._own = {
            table: [one for one in rows if one.get("robot", robot) == robot]
            for table, rows in raw.items()
            if table != ROBOT
        }
        self._read: dict[type[Row], tuple[list[Read], list[Problem]]] = {}
        self._judged: dict[type[Row], tuple[Problem, ...]] = {}
        self._indexes: dict[tuple[type[Row], Callable[[Any], Hashable]], dict[Hashable, Any]] = {}
        self._names: dict[str, frozenset[object]] = {}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Tables) and (self._robot, self._own) == (other._robot, other._own)

    __hash__ = None  # type: ignore[assignment]

    @property
    def own(self) -> Mapping[str, list[RawRow]]:
        """Return the raw rows of each table but `robot`: the robot's own, and the shared ones."""
        return self._own

    def __contains__(self, table: str) -> bool:
        return table in self._raw

    def good(self, row: type[R]) -> tuple[R, ...]:
        """Return the faultless rows of a table."""
        self.problems(row)
        return tuple(cast("R", one.row) for one in self.rows(row) if not one.wrong)

    def rows(self, row: type[Row]) -> list[Read]:
        """Return the rows of a table, including bad ones."""
        if row not in self._read:
            found: list[Problem] = []
            self._read[row] = [self._read_row(row, values, found) for values in self._of(row, found)], found
        return self._read[row][0]

    def problems(self, row: type[Row]) -> tuple[Problem, ...]:
        """Return the problems of a table's rows, by themselves and among others."""
        if row not in self._judged:
            problems = list(self._read[row][1]) if self.rows(row) or row in self._read else []
            for check in _checks(row):
                for read in self.rows(row):
                    for column, text in _until_unread(check(read.view, self)):
                        read.wrong.add(column)
                        problems.append(Problem(row.TABLE, read.label, column, text))
            self._judged[row] = tuple(problems)
        return self._judged[row]

    def names(self, table: str) -> frozenset[Any]:
        """Return the column `name` of a table's rows, including bad ones."""
        if table not in self._names:
            self._names[table] = frozenset(values.get("name") for values in self._own.get(table, ()))
        return self._names[table]

    def index(self, row: type[R], by: Callable[[R], Hashable]) -> Mapping[Hashable, R]:
        """Return the first row for each value of `by`, if its columns are readable."""
        if (row, by) not in self._indexes:
            first: dict[Hashable, Any] = {}
            for read in self.rows(row):
                for key in _until_unread(iter([read.view]), by):
                    first.setdefault(key, read.view)
            self._indexes[row, by] = first
        return self._indexes[row, by]

    def _of(self, row: type[Row], problems: list[Problem]) -> Sequence[RawRow]:
        """Return a table's rows, if it has all columns; note rows of missing robots."""
        table, known = row.TABLE, set(self._columns.get(row.TABLE, ()))
        wanted = set(columns(row))
        if known:
            problems += [Problem(table, "", name, "this column is missing") for name in sorted(wanted - known)]
            problems += [
                Problem(table, "", short(name), "lbr knows no column of this name: drop it")
                for name in sorted(known - wanted - {"robot"})
            ]
            if wanted - known:
                return ()
        if row.TABLE == ROBOT:
            return [values for values in self._raw.get(table, ()) if values.get("name") == self._robot]
        robots = [values.get("name") for values in self._raw.get(ROBOT, ())]
        for values in self._raw.get(table, ()):
            if "robot" in values and values["robot"] not in robots:
                text = f"there is no robot '{short(values['robot'])}'"
                problems.append(Problem(table, _label(row, values), "robot", text))
        return self._own.get(table, ())

    def _read_row(self, row: type[Row], values: RawRow, problems: list[Problem]) -> Read:
        label, unread, fields = _label(row, values), set[str](), dict[str, Any]()
        for name, column in columns(row).items():
            try:
                fields[name] = column.read(values.get(name))
            except WrongError as err:
                unread.add(name)
                fields[name] = column.stand_in
                problems.append(Problem(row.TABLE, label, name, str(err)))
        return Read(label, row(**fields), frozenset(unread), set(unread))


def _checks(row: type[Row]) -> tuple[Check, ...]:
    declared = ((row.whole(), _of_a_whole), (row.ASCENDING, _ascending), (row.TOGETHER, _together))
    return (*(check for says, check in declared if says), *row.CHECKS)


def _of_a_whole(row: Row, others: Others) -> Iterator[Fault]:
    whole = row.whole()
    if whole and (name := getattr(row, row.KEY[0])) not in others.names(whole):
        yield row.KEY[0], f"there is no {whole} '{short(name)}'"


def _ascending(row: Row, _: Others) -> Iterator[Fault]:
    for low, high in row.ASCENDING:
        if not getattr(row, low) < getattr(row, high):
            yield high, f"{getattr(row, high):g} is not above {low}, {getattr(row, low):g}"


def _together(row: Row, _: Others) -> Iterator[Fault]:
    for pair in row.TOGETHER:
        for name, other in (pair, pair[::-1]):
            if getattr(row, name) is None and getattr(row, other) is not None:
                yield name, f"is NULL, and {other} is not: they go together"


def _label(row: type[Row], values: RawRow) -> str:
    """Return a row's key, for people."""
    key = ("robot", *row.KEY) if "robot" in values else row.KEY
    return "/".join(short(values.get(column)) for column in key)


def _until_unread(faults: Iterator[Any], by: Callable[[Any], Any] = lambda fault: fault) -> Iterator[Any]:
    """Yield the items until one asks for an unreadable value."""
    try:
        for fault in faults:
            yield by(fault)
    except _UnreadError:
        return
