"""SQLite's refusal of a row as a sentence: the table, the column, and its permitted values."""

import re
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing

from lbr.messages.rows import short
from lbr.messages.shapes import SHAPES
from lbr.resources import robot_db_sql

_CHECK = re.compile(r"CHECK constraint failed: (.*)", re.DOTALL)
_OPTIONAL = re.compile(r"\w+ IS NULL OR (?:\((?P<inner>.*)\)|(?P<plain>.*))")
_COLUMNS = re.compile(r"(NOT NULL|UNIQUE) constraint failed: (.*)")
_TYPE = re.compile(r"cannot store (\w+) value in (\w+) column (\w+)\.(\w+)")
_TABLE = re.compile(
    r'\s*(?:INSERT(?:\s+OR\s+\w+)?\s+INTO|REPLACE\s+INTO|UPDATE(?:\s+OR\s+\w+)?|DELETE\s+FROM)\s+"?(\w+)', re.IGNORECASE
)
_TYPES = {"INTEGER": "a whole number", "REAL": "a number", "TEXT": "a text", "BLOB": "a blob"}


def words(error: str, statement: str = "") -> str:
    """Return SQLite's refusal of a row as a sentence; any other error unchanged."""
    found = _TABLE.match(_without_comments(statement))
    table = found[1] if found else ""
    if check := _CHECK.fullmatch(error):
        column, allowed = _allowed(check[1])
        return (
            f"{_place(table, column)} must be {allowed}" if allowed else f"{_place(table, '')} breaks a check: {error}"
        )
    if columns := _COLUMNS.fullmatch(error):
        places = [part.strip().partition(".") for part in columns[2].split(",")]
        names = ", ".join(column for _, _, column in places)
        if columns[1] == "UNIQUE":
            other = names.rpartition(", ")[2]
            return f"table {places[0][0]} has a row with this {names} already: change that row, or take another {other}"
        return f"{_place(places[0][0], names)} must not be NULL"
    if of_type := _TYPE.fullmatch(error):
        given, wanted = _TYPES.get(of_type[1], of_type[1]), _TYPES.get(of_type[2], of_type[2])
        return f"{_place(of_type[3], of_type[4])} must be {wanted}, not {given}"
    if error == "FOREIGN KEY constraint failed":
        return _missing(table)
    return error


def refused(script: str) -> str:
    """Return the line at which SQLite refuses a script for a new database, with the reason; empty if at none."""
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
        return run(connection, script)


def run(
    connection: sqlite3.Connection, script: str, allowed: str = "", begin: Callable[[], None] = lambda: None
) -> str:
    """Run a script up to the statement that SQLite refuses; return its line and the reason, empty if it refuses none.

    `allowed` is the reason for a statement that the connection's authorizer denies; `begin` is called before each.
    """
    for line, statement in statements(script):
        begin()
        try:
            connection.execute(statement)
        except sqlite3.Error as err:
            if allowed and any(text in str(err) for text in ("not authorized", "prohibited")):
                return f"line {line}: {allowed}"
            why = "it takes too long" if "interrupted" in str(err) else words(str(err), statement)
            return f"line {line}: {why}"
    return ""


def statements(script: str) -> Iterator[tuple[int, str]]:
    """Yield each statement of a script with the line it begins in."""
    begun, text, empty = 1, "", True
    for number, line in enumerate(script.splitlines(keepends=True), 1):
        if empty:
            begun, text = number, ""
        for part in re.findall(r"[^;]*;|[^;]+", line):
            text += part
            if part.endswith(";") and sqlite3.complete_statement(text):
                yield begun, text
                begun, text, empty = number, "", True
        empty = empty and not _without_comments(text).strip()
    if _without_comments(text).strip():
        yield begun, text


def _without_comments(statement: str) -> str:
    return re.sub(r"^\s*--.*$", "", statement, flags=re.MULTILINE)


def _allowed(check: str) -> tuple[str, str]:
    """Return the column of a CHECK, and its permitted values; empty if the CHECK is not in lbr's schema."""
    optional = _OPTIONAL.fullmatch(" ".join(check.split()))
    bare = (optional["inner"] or optional["plain"]) if optional else " ".join(check.split())
    for shape in SHAPES:
        if found := shape.allowed(bare):
            return found[0], found[1] + ", or NULL" * (optional is not None)
    return "", ""


def _place(table: str, column: str) -> str:
    place = f"table {short(table)}" if table else "a row"
    return f"{place}, {column}:" if column else place


def _missing(table: str) -> str:
    ends = ", ".join(f"{columns} must be that of a row of '{other}'" for columns, other in _references(table))
    if not ends:
        return "a row names another that is not there: add that one first, in the same transaction"
    return f"table {table}: {ends}; add that one first, in the same transaction"


def _references(table: str) -> list[tuple[str, str]]:
    """Return the columns of a table of lbr that refer to another table, with that table."""
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.executescript(robot_db_sql().read_text(encoding="utf-8"))
        return connection.execute(
            'SELECT group_concat("from", \'/\'), "table" FROM pragma_foreign_key_list(?) GROUP BY id', (table,)
        ).fetchall()
