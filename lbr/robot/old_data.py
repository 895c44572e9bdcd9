"""Data that another program kept of a robot, in files: a package's declaration of how it becomes rows here.

    file ──► Source ── read ──► OldData ── wants ──► Want(table, key, columns), Note(what has no place)

Nothing here writes: `lbr import` compares what is wanted with the rows that are there.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol

Kind = Literal["added", "changed", "clamped", "same", "no_place"]
"""The result for a value; `no_place`: nothing here could hold it."""
ForeignTables = Mapping[str, Sequence[Mapping[str, Any]]]
"""The rows of another program's database by its tables' names."""


ROWS_SHOWN = 5
"""Of those of which the same is said."""


class Note(NamedTuple):
    """The result for something in a file: `table`, `row` and `column` are its place there, and `text` is the reason."""

    kind: Kind
    table: str
    row: str
    column: str
    text: str

    def __str__(self) -> str:
        where = f"{self.table} '{self.row}'" if self.row else self.table
        return f"{where}, {self.column}: {self.text}" if self.column else f"{where}: {self.text}"


def no_place(table: str, row: str, column: str, text: str) -> Note:
    """Return the note that nothing here could hold a value."""
    return Note("no_place", table, row, column, text)


def merged(notes: Iterable[Note]) -> tuple[Note, ...]:
    """Return the notes with those that say the same of several rows as one, where the first of them stood."""
    rows: dict[Note, list[str]] = {}
    for note in notes:
        rows.setdefault(note._replace(row=""), []).append(note.row)
    return tuple(note._replace(row=_listed(of_note)) for note, of_note in rows.items())


def _listed(rows: Sequence[str]) -> str:
    more = f" and {len(rows) - ROWS_SHOWN} more" if len(rows) > ROWS_SHOWN else ""
    return ", ".join(rows[:ROWS_SHOWN]) + more


class Want(NamedTuple):
    """A row that is to have these columns; one that is not there is made only with `create`, and gets those of `made`
    too.

    A column such as `settings.left.direction` is an entry of a JSON object. `source` is where in the file it stood.
    With `text` it is told as changed: what stood there meant the same otherwise.
    """

    table: str
    key: Mapping[str, Any]
    columns: Mapping[str, Any]
    source: str
    create: bool = False
    text: str = ""
    made: Mapping[str, Any] = {}


class Here(Protocol):
    """The rows of the robot that gets the data, as SQLite holds them."""

    def rows(self, table: str) -> Sequence[Mapping[str, Any]]:
        """Return the rows of a table; none if there is no such table."""


class Choice(NamedTuple):
    """The person's choices: `of` which robot of the file."""

    of: str | None = None


class OldData(Protocol):
    """The content of a file, before its robot is known."""

    def fits(self, target: Here) -> bool:
        """Return whether a robot has what the file speaks of."""

    def wants(self, target: Here, choice: Choice) -> Iterable[Want | Note]:
        """Return which rows are wanted, and what has no place; InputError says why it cannot be told."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Source:
    """A file as readers get it: its name, where it lies, its text, its JSON or the rows of its database, if it is
    such."""

    name: str
    folder: str
    content: bytes = field(repr=False)
    text: str | None = field(default=None, repr=False)
    json: Any = field(default=None, repr=False)
    tables: Callable[[], ForeignTables | None] = field(default=lambda: None, repr=False)


class ReadOldData(Protocol):
    """Reads a file; None if it is of another format, InputError names the fault of one of this."""

    def __call__(self, source: Source) -> OldData | None:
        """Return what is in it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OldFormat:
    """A format of files of another program: its `name` for `--as`, a `summary`, and `module:function` that reads it."""

    name: str
    summary: str
    read: str
