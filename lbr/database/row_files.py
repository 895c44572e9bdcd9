"""Rows as text files that git compares well: a folder for each robot with a file for each table. Pure except `read`,
`write`.

rows/lbr/capability.json    the rows of 'lbr', by their keys; JSON of the database is JSON there
rows/_shared/phrase.json    the rows that all robots share
"""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from msgspec import Struct

from lbr import disk
from lbr.database import given_files
from lbr.database.columns import json_strictly
from lbr.database.difference import same
from lbr.database.reading import ROBOT, Problem, RawRow, RawTables
from lbr.database.tables import WRITTEN_BY_LBR, Schema
from lbr.errors import InputError, RowError
from lbr.messages.rows import short

SHARED = "_shared"
"""The folder of rows that all robots share; no robot can have this name."""
MOST_BYTES = 32_000_000
"""Of one file: a hundred times the largest table that comes with lbr."""
_SUFFIX = ".json"


class File(Struct, frozen=True, kw_only=True):
    """One table of one robot as text; `robot` is SHARED for rows of all robots."""

    robot: str
    table: str
    text: str

    @property
    def name(self) -> str:
        """Return its path in the folder."""
        return f"{self.robot}/{self.table}{_SUFFIX}"


def written(tables: RawTables, schema: Schema, robot: str | None = None) -> tuple[File, ...]:
    """Return the files of all tables, including empty ones; optionally of one robot, without shared rows."""
    files = []
    for folder in sorted(row["name"] for row in tables.get(ROBOT, ()) if robot in {None, row["name"]}):
        for table in schema:
            owner = _owner(table, schema)
            if owner:
                rows = [row for row in tables.get(table, ()) if row[owner] == folder]
                files.append(File(robot=folder, table=table, text=_text(table, rows, schema)))
    if robot is None:
        shared = [table for table in schema if not _owner(table, schema)]
        files += [File(robot=SHARED, table=table, text=_text(table, tables.get(table, ()), schema)) for table in shared]
    return tuple(files)


def applied(files: tuple[File, ...], tables: RawTables, schema: Schema) -> RawTables:
    """Return the tables with these files; a table without a file stays. RowError names file, row and column."""
    after: dict[str, list[RawRow]] = {table: list(rows) for table, rows in tables.items()}
    faults: list[str] = []
    for file in files:
        rows, wrong = _rows(file, schema)
        faults += wrong
        owner = _owner(file.table, schema) if file.table in schema else ""
        if not wrong:
            rest = [row for row in after[file.table] if owner and row[owner] != file.robot]
            after[file.table] = [*rest, *_with_what_lbr_writes(file.table, rows, tables, schema)]
    if faults:
        raise RowError(tuple(faults))
    return after


def place(problem: Problem, schema: Schema) -> str:
    """Return a row's problem as a sentence with the file."""
    if problem.table not in schema:
        return str(problem)
    owner, _, rest = problem.row.partition("/")
    folder, row = (owner, rest or owner) if _owner(problem.table, schema) else (SHARED, problem.row)
    column = f", {problem.column}" if problem.column else ""
    return f"{folder}/{problem.table}{_SUFFIX}, '{row}'{column}: {problem.text}"


def write(folder: Path, files: tuple[File, ...]) -> None:
    """Write files into a folder, each whole or not at all; other files stay. Raise InputError with the ones that
    fail."""
    for file in files:
        if file.name.count("/") != 1 or file.name.startswith("."):
            raise InputError(f"'{short(file.name)}' would be no file in {folder}: rename the robot or the table")
        path = folder / file.name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with disk.replacing(path) as draft:
                draft.write_text(file.text, encoding="utf-8", errors="surrogateescape")
        except OSError as err:
            raise InputError(f"{path} cannot be written ({err.strerror}): check the folder") from err


def read(folder: Path, robot: str | None = None) -> tuple[File, ...]:
    """Read the files of a folder, optionally of one robot; raise InputError with unreadable and foreign files."""
    files = []
    try:
        for place in sorted(one for one in folder.iterdir() if one.is_dir() and not one.name.startswith(".")):
            if robot in {None, place.name}:
                files += [_read(place, path) for path in sorted(place.iterdir()) if path.suffix == _SUFFIX]
    except OSError as err:
        raise InputError(f"{err.filename} cannot be read ({err.strerror})") from err
    if not files:
        whose = f"{robot}/" if robot else "lbr/"
        raise InputError(
            f"{folder} has no rows in it: files such as {whose}capability.json, as `lbr db export` writes them"
        )
    return tuple(files)


def _read(place: Path, path: Path) -> File:
    text = given_files.read(path, MOST_BYTES).decode("utf-8-sig", errors="surrogateescape")
    return File(robot=place.name, table=path.stem, text=text)


def _owner(table: str, schema: Schema) -> str:
    """Return the column with a row's robot; empty for rows that all robots share."""
    return "name" if table == ROBOT else "robot" if "robot" in schema[table] else ""


def _text(table: str, rows: Any, schema: Schema) -> str:
    keys = schema.keys_of[table]
    objects = [
        {name: _json(value) for name, value in row.items() if name != "robot" and (table, name) not in WRITTEN_BY_LBR}
        for row in sorted(rows, key=lambda row: tuple((isinstance(row[name], str), row[name]) for name in keys))
    ]
    return json.dumps(objects, ensure_ascii=False, indent=2) + "\n"


def _json(value: object) -> object:
    """Return a value for a file: a JSON object or list as such, if that is lossless."""
    if isinstance(value, str) and value[:1] in {"{", "["}:
        try:
            parsed = json_strictly(value)
        except (ValueError, RecursionError):
            return value
        if same(_stored(parsed), value):
            return parsed
    return value


def _stored(value: object) -> object:
    if isinstance(value, dict | list):
        return json.dumps(value, ensure_ascii=False)
    return int(value) if isinstance(value, bool) else value


def _rows(file: File, schema: Schema) -> tuple[list[RawRow], list[str]]:
    """Return the rows of a file, and its faults."""
    if file.table not in schema:
        return [], [f"{file.name}: there is no table '{short(file.table)}': {', '.join(sorted(schema))}"]
    if (file.robot == SHARED) == bool(_owner(file.table, schema)):
        whose = (
            "every robot's: it stands in " + SHARED if file.robot != SHARED else "a robot's: it stands in its folder"
        )
        return [], [f"{file.name}: a row of {file.table} is {whose}"]
    try:
        parsed = json_strictly(file.text)
    except (RecursionError, ValueError) as err:
        return [], [_no_json(file, err)]
    if not isinstance(parsed, list):
        return [], [f"{file.name}: is not a list of rows"]
    rows, faults, seen = [], [], set()
    for number, values in enumerate(parsed, 1):
        row, wrong = _row(file, number, values, schema)
        key = tuple(row.get(name) for name in schema.keys_of[file.table])
        if not wrong and key in seen:
            wrong = [f"{_at(file, number, values, schema)}: is there twice"]
        seen.add(key)
        rows.append(row)
        faults += wrong
    return rows, faults


def _no_json(file: File, err: Exception) -> str:
    if isinstance(err, json.JSONDecodeError):
        return f"{file.name}, line {err.lineno}: is not JSON ({err.msg}); is it cut off?"
    return f"{file.name}: is not JSON: {'nested too deeply' if isinstance(err, RecursionError) else err}"


def _row(file: File, number: int, values: object, schema: Schema) -> tuple[RawRow, list[str]]:
    at = _at(file, number, values, schema)
    if not isinstance(values, dict):
        return {}, [f"{at}: is not an object of columns"]
    columns = {name for name in schema[file.table] if name != "robot" and (file.table, name) not in WRITTEN_BY_LBR}
    faults = [f"{at}, {short(name)}: {file.table} has no such column" for name in values if name not in columns]
    row: dict[str, Any] = {}
    for name in schema[file.table]:
        if name == "robot":
            row[name] = file.robot
        elif name in values:
            row[name] = _stored(values[name])
        elif name in columns:
            try:
                row[name] = schema.default(file.table, name)
            except LookupError:
                faults.append(f"{at}, {name}: is missing, and has no default")
    if file.table == ROBOT and row.get("name") != file.robot:
        faults.append(f"{at}, name: must be '{short(file.robot)}', as its folder")
    return row, faults


def _at(file: File, number: int, values: object, schema: Schema) -> str:
    keys = [name for name in schema.keys_of[file.table] if name != "robot"]
    told = "/".join(short(values.get(name)) for name in keys) if isinstance(values, dict) else ""
    return f"{file.name}, row {number}" + (f" ('{told}')" if told else "")


def _with_what_lbr_writes(
    table: str, rows: list[RawRow], tables: Mapping[str, Any], schema: Schema
) -> Iterator[RawRow]:
    """Yield rows with the columns that no file has: with their present values, or those of a new row."""
    own = [name for name in schema[table] if (table, name) in WRITTEN_BY_LBR]
    keys = schema.keys_of[table]
    now = {tuple(row[name] for name in keys): row for row in tables.get(table, ())} if own else {}
    for row in rows:
        there = now.get(tuple(row[name] for name in keys))
        kept = {name: there[name] if there is not None else schema.default(table, name) for name in own}
        yield {**row, **kept}
