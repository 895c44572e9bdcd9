"""State tables as files: CSV as spreadsheets write it, and JSON, with the established column names. Pure."""

import contextlib
import csv
import io
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, cast, get_args

import msgspec

from lbr.apps.behaviours.table import DEADLINE, MOST_FAULTS, NEXT, STATE, TYPE
from lbr.messages.behaviour import LONGEST_CELL, MOST_ROWS, BehaviourRow, RowType
from lbr.messages.unreadable import UNREADABLE

LARGEST_BYTES = 4_000_000
OUTPUT = "O:"
_TYPES = get_args(RowType)
_COMMA = re.compile(r"(?<=\d),(?=\d)")
_POINT = re.compile(r"(?<=\d)\.(?=\d)")
_TEXTS = {TYPE, STATE, NEXT, f"{OUTPUT}speech"}
"""Columns of text, in which a comma is not a decimal mark."""
_HEADINGS = {name.casefold(): name for name in (TYPE, STATE, NEXT, DEADLINE)}
_SEPARATOR = re.compile(r"^sep=([,;|\t])\r?\n", re.IGNORECASE)


class FileFault(NamedTuple):
    """A problem in a file: line (0: the whole file), column, and what to do."""

    line: int
    column: str
    text: str

    def __str__(self) -> str:
        at = f"line {self.line}, " if self.line else ""
        return f"{at}{self.column}: {self.text}" if self.column else f"{at.replace(', ', ': ')}{self.text}"


class Read(NamedTuple):
    """The rows of a file, the line of each by its step, and the faults. A row lacks its unreadable cells."""

    rows: tuple[BehaviourRow, ...]
    lines: Mapping[int, int]
    faults: tuple[FileFault, ...]


def read(content: bytes, name: str, *, json: bool) -> Read:
    """Read a file as the table `name`; faults are returned, never raised."""
    if len(content) > LARGEST_BYTES:
        return _refused(f"it has {len(content)} bytes, and {LARGEST_BYTES} are the most")
    return _of_json(content, name) if json else _of_csv(content, name)


def to_csv(rows: Iterable[BehaviourRow], delimiter: str = ",") -> str:
    """Return rows as CSV, in the order of their steps."""
    ordered = sorted(rows, key=lambda row: row.step)
    conditions = list(dict.fromkeys(column for row in ordered for column in row.conditions))
    results = list(dict.fromkeys(column for row in ordered for column in row.outputs))
    deadlines = any(row.deadline_s is not None for row in ordered)
    file = io.StringIO()
    writer = csv.writer(file, delimiter=delimiter, lineterminator="\r\n")
    writer.writerow(
        [TYPE, STATE, *conditions, *(OUTPUT + column for column in results), NEXT, *([DEADLINE] if deadlines else [])]
    )
    for row in ordered:
        deadline = [f"{row.deadline_s:g}" if row.deadline_s is not None else ""] if deadlines else []
        inputs = [row.conditions.get(column, "") for column in conditions]
        outputs = {OUTPUT + column: row.outputs.get(column, "") for column in results}
        if delimiter == ";":  # spreadsheets that separate by semicolons have decimal commas
            inputs, deadline = ([_with_mark(",", cell) for cell in cells] for cells in (inputs, deadline))
            outputs = {name: cell if name in _TEXTS else _with_mark(",", cell) for name, cell in outputs.items()}
        writer.writerow([row.type, row.state, *inputs, *outputs.values(), row.next_state, *deadline])
    return file.getvalue()


def to_json(rows: Iterable[BehaviourRow]) -> bytes:
    """Return rows as JSON: the rows of each state, in the order of their steps."""
    by_state: dict[str, list[dict[str, object]]] = {}
    for row in sorted(rows, key=lambda row: row.step):
        entry: dict[str, object] = {
            "Row": row.step,
            TYPE: row.type,
            STATE: row.state,
            "Inputs": row.conditions,
            "Outputs": row.outputs,
            NEXT: row.next_state,
        }
        if row.deadline_s is not None:
            entry[DEADLINE] = row.deadline_s
        by_state.setdefault(row.state, []).append(entry)
    return msgspec.json.format(msgspec.json.encode(by_state), indent=1) + b"\n"


def text_of(content: bytes) -> str | None:
    """Decode a spreadsheet's text: UTF-8, UTF-16 with a byte order mark, or else Windows-1252. None: not a text."""
    try:
        if content[:2] in {b"\xff\xfe", b"\xfe\xff"}:
            return content.decode("utf-16")
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        if content[:2] in {b"\xff\xfe", b"\xfe\xff"}:
            return None
        text = content.decode("cp1252", errors="replace")
    return None if "\0" in text else text


def _of_csv(content: bytes, name: str) -> Read:
    text = text_of(content)
    if text is None:
        return _refused("it is no text: save it as CSV (UTF-8)")
    delimiter, skipped = _delimiter(text), 0
    if (mark := _SEPARATOR.match(text)) is not None:
        text, skipped = text[mark.end() :], 1
    if text[:2] == "PK":
        return _refused("it is a spreadsheet's own file: save it as CSV (UTF-8)")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    commas = delimiter != "," and _has_commas(text, delimiter)
    rows: list[BehaviourRow] = []
    lines: dict[int, int] = {}
    faults: list[FileFault] = []
    try:
        header = [_heading(column) for column in next(reader, [])]
        faults += _of_header(header, reader.line_num + skipped)
        if any(fault.column in {STATE, NEXT} for fault in faults):
            return Read((), {}, tuple(faults))
        before = reader.line_num
        for cells in reader:
            line, before = before + 1 + skipped, reader.line_num
            if not any(cell.strip() for cell in cells):
                continue
            if len(rows) >= MOST_ROWS or len(faults) >= MOST_FAULTS:
                faults.append(FileFault(line, "", f"the rest is not read: {MOST_ROWS} rows are the most"))
                break
            row = _row(name, len(rows) + 1, line, header, cells, faults, commas=commas)
            lines[row.step] = line
            rows.append(row)
    except csv.Error as err:
        faults.append(FileFault(reader.line_num + skipped, "", f"it is no CSV: {err}"))
    return Read(tuple(rows), lines, tuple(faults))


def _of_header(header: Sequence[str], line: int) -> Iterator[FileFault]:
    for column in (STATE, NEXT):
        if column not in header:
            found = ", ".join(one[:40] for one in header[:6] if one) or "nothing"
            yield FileFault(
                line, column, f"this column is missing; the first line must name the columns, and has {found}"
            )
    for column, times in Counter(header).items():
        if column and times > 1:
            yield FileFault(line, column[:80], "this column is there twice")
        if len(column) > 80:
            yield FileFault(line, column[:80], "the name of a column has 80 characters at most")
        if ":" in column and not column.startswith(OUTPUT):
            yield FileFault(line, column[:80], "a column with ':' is an output and begins with O:, such as O:level")


def _row(
    name: str,
    step: int,
    line: int,
    header: Sequence[str],
    cells: Sequence[str],
    faults: list[FileFault],
    *,
    commas: bool,
) -> BehaviourRow:
    given = {column: cell.strip() for column, cell in zip(header, cells, strict=False) if column}
    beyond = [cell for cell in cells[len(header) :] if cell.strip()]
    if beyond:
        faults.append(FileFault(line, "", f"'{beyond[0][:40]}' stands beyond the last column"))
    nameless = [cell for column, cell in zip(header, cells, strict=False) if not column and cell.strip()]
    if nameless:
        faults.append(FileFault(line, "", f"'{nameless[0][:40]}' stands in a column without a name"))
    if commas:
        for column in [one for one in given if one not in _TEXTS]:
            if any(_POINT.search(part) for part in given[column].split('"')[::2]):
                shown = given[column][:40]
                text = f"'{shown}' has a point, and the numbers of this file have decimal commas: write one mark"
                faults.append(FileFault(line, column, text))
                del given[column]
            else:
                given[column] = _with_mark(".", given[column])
    return _made(name, step, line, given, faults)


def _heading(text: str) -> str:
    """Normalise the name of a column: blanks, and the case of the established names."""
    name = " ".join(text.split())
    if name[: len(OUTPUT)].upper() == OUTPUT:
        return OUTPUT + name[len(OUTPUT) :].strip()
    return _HEADINGS.get(name.casefold(), name)


def _has_commas(text: str, delimiter: str) -> bool:
    """Return whether the file has decimal commas; one such cell decides for all."""
    header: list[str] = []
    with contextlib.suppress(csv.Error):
        for cells in csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True):
            if any(_COMMA.search(cell) for name, cell in zip(header, cells, strict=False) if name not in _TEXTS):
                return True
            header = header or [_heading(cell) for cell in cells]
    return False


def _with_mark(mark: str, cell: str) -> str:
    """Replace the decimal mark in a cell's numbers; quoted texts stay."""
    parts = cell.split('"')
    parts[::2] = [(_POINT if mark == "," else _COMMA).sub(mark, part) for part in parts[::2]]
    return '"'.join(parts)


def _made(name: str, step: int, line: int, given: Mapping[str, str], faults: list[FileFault]) -> BehaviourRow:
    """Make a row of its cells; report the cells that do not fit, and leave them out."""
    kind = given.get(TYPE, "").strip()
    kind = kind if kind in _TYPES else kind.lower() if kind.lower() in _TYPES else "#" if kind[:1] == "#" else kind
    good: dict[str, str] = {}
    if kind not in _TYPES:
        faults.append(
            FileFault(line, TYPE, f"'{kind[:40]}' is no type: leave it empty, or write start, entry, end, fail or #")
        )
        kind = ""
    for column, cell in given.items():
        most = 80 if column in {STATE, NEXT} else LONGEST_CELL
        if len(cell) > most:
            faults.append(FileFault(line, column[:80], f"it has {len(cell)} characters, and {most} are the most"))
        elif any(ord(one) < 32 for one in cell):
            faults.append(
                FileFault(line, column[:80], "it has a line break or another character that cannot be printed")
            )
        else:
            good[column] = cell
    deadline = _deadline(good.get(DEADLINE, ""), line, faults)
    own = {TYPE, STATE, NEXT, DEADLINE}
    return BehaviourRow(
        behaviour=name,
        step=step,
        type=kind,  # type: ignore[arg-type]
        state=good.get(STATE, ""),
        conditions={column: cell for column, cell in good.items() if cell and column not in own and ":" not in column},
        outputs={
            column[len(OUTPUT) :].strip() or "O:": cell
            for column, cell in good.items()
            if cell and column.startswith(OUTPUT)
        },
        next_state=good.get(NEXT, ""),
        deadline_s=deadline,
    )


def _deadline(text: str, line: int, faults: list[FileFault]) -> float | None:
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value <= 86400.0:
        faults.append(FileFault(line, DEADLINE, f"'{text[:40]}' is no time: write seconds from 0.1 to 86400"))
        return None
    return value


def _delimiter(text: str) -> str:
    """Return the separator of cells: by Excel's `sep=` line, else the most frequent one in the first line."""
    if (mark := _SEPARATOR.match(text)) is not None:
        return mark[1]
    first = text[: text.find("\n")] if "\n" in text else text
    return max(",;\t", key=first.count)


def _of_json(content: bytes, name: str) -> Read:
    try:
        parsed = msgspec.json.decode(content[3:] if content[:3] == b"\xef\xbb\xbf" else content)
    except UNREADABLE as err:
        return _refused(f"it is no JSON: {err}")
    faults: list[FileFault] = []
    given = list(_json_rows(parsed, faults))
    numbers = [entry.get("Row") for _, entry in given]
    if given and len(set(map(str, numbers))) == len(given) and all(isinstance(entry, int) for entry in numbers):
        given.sort(key=lambda entry: cast("int", entry[1]["Row"]))
    typed = any(entry.get(TYPE) for _, entry in given)
    ends = frozenset[str]() if typed else _leading_nowhere(given)
    rows = []
    for step, (place, entry) in enumerate(given[:MOST_ROWS], start=1):
        cells = _json_cells(place, entry, faults)
        if not typed:
            cells[TYPE] = "end" if cells[STATE] in ends else "start" if step == 1 else ""
        own = len(faults)
        rows.append(_made(name, step, 0, cells, faults))
        faults[own:] = [fault._replace(column=f"{place}, {fault.column}") for fault in faults[own:]]
    if len(given) > MOST_ROWS:
        faults.append(FileFault(0, "", f"it has {len(given)} rows, and {MOST_ROWS} are the most"))
    return Read(tuple(rows), {}, tuple(faults[:MOST_FAULTS]))


def _json_rows(parsed: object, faults: list[FileFault]) -> Iterator[tuple[str, dict[str, object]]]:
    """Yield each row after its place in the file."""
    if isinstance(parsed, dict):
        groups = [(f"state '{str(state)[:40]}'", state, rows) for state, rows in parsed.items()]
    elif isinstance(parsed, list):
        groups = [("the list", "", parsed)]
    else:
        faults.append(FileFault(0, "", "it is no table: write an object of states, each a list of rows"))
        return
    for place, state, rows in groups:
        if not isinstance(rows, list):
            faults.append(FileFault(0, place, "it has no list of rows"))
            continue
        for number, entry in enumerate(rows, start=1):
            if isinstance(entry, dict):
                yield f"{place}, row {number}", {STATE: state, **entry}
            else:
                faults.append(FileFault(0, f"{place}, row {number}", "it is no object"))


def _json_cells(place: str, entry: Mapping[str, object], faults: list[FileFault]) -> dict[str, str]:
    known = {"Row", TYPE, STATE, NEXT, DEADLINE, "Inputs", "Outputs"}
    cells: dict[str, str] = {}
    for column in (TYPE, STATE, NEXT, DEADLINE):
        cells[column] = _text(entry.get(column), f"{place}, {column}", faults)
    for part, prefix in (("Inputs", ""), ("Outputs", OUTPUT)):
        given = entry.get(part)
        if given is None:
            continue
        if not isinstance(given, dict):
            faults.append(FileFault(0, f"{place}, {part}", "it is no object of columns and cells"))
            continue
        for column, value in given.items():
            if not 1 <= len(column) <= 78 or (not prefix and (":" in column or column in known)):
                faults.append(FileFault(0, f"{place}, {column[:80]}", "a column cannot be called so"))
            else:
                cells[prefix + column] = _text(value, f"{place}, {column}", faults)
    there = f"there is no such field: {', '.join(sorted(known))}"
    faults += [FileFault(0, f"{place}, {column[:80]}", there) for column in sorted(set(entry) - known)]
    return cells


def _text(value: object, place: str, faults: list[FileFault]) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return value.strip()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float) and abs(value) < 1e15:
        return f"{value:.12g}"
    faults.append(FileFault(0, place, "it is neither a text nor a number that anything could be"))
    return ""


def _leading_nowhere(given: Iterable[tuple[str, Mapping[str, object]]]) -> frozenset[str]:
    """Return the states without a way to another state: the ends of a file without types."""
    states: set[str] = set()
    leading: set[str] = set()
    for _, one in given:
        state, following = (_text(one.get(column), column, []) for column in (STATE, NEXT))
        states.add(state)
        if following not in {state, ""}:
            leading.add(state)
    return frozenset(states - leading)


def _refused(text: str) -> Read:
    return Read((), {}, (FileFault(0, "", text),))
