"""Another program's data about a robot, in files: a package's declaration of its conversion to rows.

    file ──► Source ── read ──► OldData ── wants ──► Want(table, key, columns), Note(what has no place)

Nothing here writes: `lbr import` compares the wanted rows with the existing ones.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol

Kind = Literal["added", "changed", "clamped", "same", "no_place"]
"""The result for a value; `no_place`: no column here can hold it."""
ForeignTables = Mapping[str, Sequence[Mapping[str, object]]]
"""The rows of another program's database by its tables' names."""


ROWS_SHOWN = 5
"""The number of rows that a combined note names."""


class Note(NamedTuple):
    """The result for one value of a file: `table`, `row` and `column` are its place there, and `text` is the reason."""

    kind: Kind
    table: str
    row: str
    column: str
    text: str

    def __str__(self) -> str:
        where = f"{self.table} '{self.row}'" if self.row else self.table
        return f"{where}, {self.column}: {self.text}" if self.column else f"{where}: {self.text}"


def no_place(table: str, row: str, column: str, text: str) -> Note:
    """Return the note that nothing here can hold a value."""
    return Note("no_place", table, row, column, text)


def merged(notes: Iterable[Note]) -> tuple[Note, ...]:
    """Return the notes, with equal ones of several rows combined at the place of the first."""
    rows: dict[Note, list[str]] = {}
    for note in notes:
        rows.setdefault(note._replace(row=""), []).append(note.row)
    return tuple(note._replace(row=_listed(of_note)) for note, of_note in rows.items())


def _listed(rows: Sequence[str]) -> str:
    more = f" and {len(rows) - ROWS_SHOWN} more" if len(rows) > ROWS_SHOWN else ""
    return ", ".join(rows[:ROWS_SHOWN]) + more


class Want(NamedTuple):
    """A row with wanted columns; a missing one is made only with `create`, and also gets the columns `made`.

    A column such as `settings.left.direction` is an entry of a JSON object. `source` is its place in the file. With
    `text`, it is reported as converted from another form of the same value.
    """

    table: str
    key: Mapping[str, Any]
    columns: Mapping[str, Any]
    source: str
    create: bool = False
    text: str = ""
    made: Mapping[str, Any] = {}


class Here(Protocol):
    """The rows of the robot that gets the data, as in SQLite."""

    def rows(self, table: str) -> Sequence[Mapping[str, Any]]:
        """Return the rows of a table; empty if there is no such table."""


class Choice(NamedTuple):
    """The person's choices: `of` is the robot in the file."""

    of: str | None = None


class OldData(Protocol):
    """The content of a file, before its robot is known."""

    def fits(self, target: Here) -> bool:
        """Return whether a robot has the parts of the file."""

    def wants(self, target: Here, choice: Choice) -> Iterable[Want | Note]:
        """Return the wanted rows, and notes about values without a place; raise InputError if that is unknown."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Source:
    """A file for readers: its name, its place, its text, and its JSON or database rows if it has them."""

    name: str
    folder: str
    content: bytes = field(repr=False)
    text: str | None = field(default=None, repr=False)
    json: object = field(default=None, repr=False)
    tables: Callable[[], ForeignTables | None] = field(default=lambda: None, repr=False)


class ReadOldData(Protocol):
    """Reads a file; returns None for another format, and raises InputError with the fault of its own."""

    def __call__(self, source: Source) -> OldData | None:
        """Return the content."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OldFormat:
    """A format of files of another program: its `name` for `--as`, a `summary`, and `module:function` that reads it."""

    name: str
    summary: str
    read: str
