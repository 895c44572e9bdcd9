"""The merge of wanted rows into present ones, which never replaces a person's values unasked. Pure."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from json import dumps

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.apps.motions.commands import motion_files
from lbr.database.columns import WrongError, columns, json_strictly, raw
from lbr.database.reading import ROBOT, Problem, RawRow, RawTables, Tables
from lbr.database.rows import CapabilityRow, DeviceRow, ExternalCommandRow, RobotRow, RobotRows
from lbr.errors import InputError
from lbr.messages.calibration import CalibrationValue
from lbr.messages.faces import Button, Motor
from lbr.messages.joints import Joint, Motion, MotionRow, MotionStep, motions_of
from lbr.messages.plain import one_line
from lbr.messages.rows import Row, short
from lbr.messages.schema import JsonObject
from lbr.robot.old_data import Note, Want

TABLES: Mapping[str, type[Row]] = {
    one.TABLE: one for one in (RobotRow, CapabilityRow, DeviceRow, ExternalCommandRow, CalibrationValue, Motor, Button)
}
"""The tables that data of a former program may become."""


class RowsOfRobot(Struct, frozen=True):
    """One robot's rows from the tables of all, for readers of old data."""

    tables: RawTables
    robot: str

    def rows(self, table: str) -> Sequence[Mapping[str, object]]:
        """Return the rows of a table."""
        column = "name" if table == ROBOT else "robot"
        return [row for row in self.tables.get(table, ()) if row.get(column, self.robot) == self.robot]


class Imported(Struct, frozen=True, kw_only=True):
    """Rows to write, the result of everything, and the person's values that would be replaced."""

    rows: tuple[Row, ...] = ()
    notes: tuple[Note, ...] = ()
    conflicts: tuple[str, ...] = ()


def without(imported: Imported, robot: str, problems: Iterable[Problem]) -> Imported:
    """Return the import without the rows that have problems, each with all rows of its whole; notes name these."""
    why = {(problem.table, problem.row): problem for problem in problems}
    refused: dict[tuple[str, str], Problem] = {}
    for row in imported.rows:
        if problem := why.get((row.TABLE, _row_name((robot, *row.key)))):
            refused.setdefault(_whole(row), problem)
    notes = [note for note in imported.notes if (note.table, note.row) not in refused]
    notes += [Note("no_place", *whole, problem.column, _without_advice(problem)) for whole, problem in refused.items()]
    rows = tuple(row for row in imported.rows if _whole(row) not in refused)
    return Imported(rows=rows, notes=tuple(notes), conflicts=imported.conflicts)


def _without_advice(problem: Problem) -> str:
    """Return the problem without its advice, which is for a robot's own rows."""
    return problem.text.partition(": ")[0]


def _whole(row: Row) -> tuple[str, str]:
    return (row.PART_OF, _row_name(row.key[:1])) if row.PART_OF else (row.TABLE, _row_name(row.key))


class _State(Struct):
    """A row before, after, and as shipped; None: missing."""

    before: dict[str, object] | None
    after: dict[str, object]
    shipped: dict[str, object] | None


def take(wants: Iterable[Want], here: RowsOfRobot, shipped: RawTables, *, replacing: bool) -> Imported:
    """Apply wants to a robot's rows; without `replacing`, values that differ from the shipped ones stay."""
    taking = _Taking(here, RowsOfRobot(shipped, here.robot), replacing=replacing)
    for want in wants:
        taking.add(want)
    return taking.done()


class _Taking:
    """Applies one want after the other; several may concern one row."""

    def __init__(self, here: RowsOfRobot, shipped: RowsOfRobot, *, replacing: bool) -> None:
        self._present = here
        self._shipped = shipped
        self._replacing = replacing
        self._states: dict[tuple[str, str], _State] = {}
        self._wanted: dict[tuple[str, str, str], object] = {}
        self._notes: list[Note] = []
        self._conflicts: list[str] = []

    def add(self, want: Want) -> None:
        """Apply a want, and note the result."""
        key = tuple(want.key[name] for name in TABLES[want.table].KEY)
        row_name = _row_name(key)
        state = self._state(want, key)
        if state.before is None and not want.create:
            self._notes.append(Note("no_place", want.table, row_name, "", f"{want.source}: there is no such row here"))
            return
        changed = [
            column for column, value in want.columns.items() if self._column(want, state, row_name, column, value)
        ]
        if not changed:
            return
        if state.before is None:
            state.after |= want.made
            self._notes.append(Note("added", want.table, row_name, "", want.source))
        if want.text:
            self._notes.append(Note("changed", want.table, row_name, "", f"{want.source}: {want.text}"))

    def done(self) -> Imported:
        """Return the rows; invalid ones are noted and left out."""
        rows: list[Row] = []
        for (table, row_name), state in self._states.items():
            kind = TABLES[table]
            if state.after == state.before or set(state.after) <= set(kind.KEY):
                continue
            try:
                rows.append(_row(kind, state.after))
            except (WrongError, msgspec.ValidationError) as err:
                self._notes = [one for one in self._notes if (one.table, one.row) != (table, row_name)]
                self._notes.append(Note("no_place", table, row_name, "", one_line(str(err)[:200])))
        return Imported(rows=tuple(rows), notes=tuple(self._notes), conflicts=tuple(self._conflicts))

    def _state(self, want: Want, key: tuple[object, ...]) -> _State:
        if (want.table, _row_name(key)) not in self._states:
            kind = TABLES[want.table]
            before = _existing(kind, key, self._present)
            state = _State(before, {**want.key, **(before or {})}, _existing(kind, key, self._shipped))
            self._states[want.table, _row_name(key)] = state
        return self._states[want.table, _row_name(key)]

    def _column(self, want: Want, state: _State, row_name: str, column: str, value: object) -> bool:
        """Apply a column, and return whether it changes; of two that contradict each other the first counts."""
        place = want.table, row_name, column
        if place in self._wanted:
            if (first := self._wanted[place]) != value:
                text = f"{want.source}: {short(value)}, and before that {short(first)}, which counts"
                self._notes.append(Note("no_place", *place, text))
            return False
        self._wanted[place] = value
        present = _get(state.after, column)
        if state.before is not None and present == value:
            self._notes.append(Note("same", want.table, row_name, column, want.source))
            return False
        if state.before is not None and not self._replacing and present != _get(state.shipped or {}, column):
            self._conflicts.append(
                f"{want.table} '{row_name}', {column} is {short(present)} here, and {short(value)} there"
            )
            return False
        _set(state.after, column.split("."), value)
        if state.before is not None:
            text = (
                f"{want.source}: {'nothing' if present is None or present == '' else short(present)} -> {short(value)}"
            )
            self._notes.append(Note("changed", want.table, row_name, column, text))
        return True


def take_motions(motions: Iterable[Motion], rows: RobotRows, shipped: RawTables, *, replacing: bool) -> Imported:
    """Return the rows of motions, clipped to the joints' limits, and the notes; `replacing` is as for `take`."""
    known = {motion.name: motion for motion in motions_of(rows.of(MotionRow), rows.of(MotionStep))}
    first = Tables(shipped, rows.robot.name, {})
    as_shipped = motions_of(first.good(MotionRow), first.good(MotionStep))
    joints = rows.of(Joint)
    written: list[Row] = []
    notes: list[Note] = []
    conflicts: list[str] = []
    for asked in motions:
        motion, _ = motion_files.within_limits(replace(asked, builtin=False), joints, clip=True)
        motion_files.summary(motion, joints)
        notes += _clamped(asked, motion)
        before = known.get(motion.name)
        if before == motion:
            notes.append(Note("same", "motion", motion.name, "", "its key frames are there"))
            continue
        if before is not None and not replacing and before not in as_shipped:
            conflicts.append(f"motion '{motion.name}' is there already")
        count = len(motion.frames)
        text = f"{count} key frame{'s' if count != 1 else ''}, {sum(frame.duration_s for frame in motion.frames):.2f} s"
        notes.append(Note("changed" if before is not None else "added", "motion", motion.name, "", text))
        written += motion.rows
    return Imported(rows=tuple(written), notes=tuple(notes), conflicts=tuple(conflicts))


def _row_name(key: Iterable[object]) -> str:
    return "/".join(map(short, key))


def _clamped(asked: Motion, motion: Motion) -> Iterator[Note]:
    clamped: dict[str, tuple[int, float, float]] = {}
    for wanted, had in zip(asked.frames, motion.frames, strict=True):
        for name, angle in wanted.positions.items():
            now = had.positions[name]
            if now != angle:
                count, worst, limit = clamped.get(name, (0, angle, now))
                further = (angle, now) if abs(angle - now) >= abs(worst - limit) else (worst, limit)
                clamped[name] = (count + 1, *further)
    for name, (count, angle, limit) in clamped.items():
        such = f"as {angle:.3f} to {limit:.3f} rad"
        text = f"{count} of {len(asked.frames)} angles brought within the joint's limits, {such}"
        yield Note("clamped", "motion_step", motion.name, f"positions.{name}", text)


def _existing(kind: type[Row], key: tuple[object, ...], here: RowsOfRobot) -> dict[str, object] | None:
    for values in here.rows(kind.TABLE):
        if tuple(values.get(name) for name in kind.KEY) == key:
            return _read(kind, values)
    return None


def _read(kind: type[Row], values: RawRow) -> dict[str, object]:
    columns_of: dict[str, object] = {}
    for name, column in columns(kind).items():
        try:
            columns_of[name] = msgspec.json.decode(msgspec.json.encode(column.read(values.get(name))))
        except WrongError as err:
            raise InputError(
                f"{kind.TABLE} '{short(values.get('name'))}', {name}: {err}; 'lbr db check' lists all problems"
            ) from err
    return columns_of


def _row(kind: type[Row], after: Mapping[str, object]) -> Row:
    """Return a row of columns; raise WrongError or ValidationError with the faulty one."""
    row = msgspec.convert(dict(after), kind)
    for name, value in raw(row).items():
        try:
            columns(kind)[name].read(value)
        except WrongError as err:
            raise WrongError(f"{name}: {err}") from err
    return row


def _get(row: Mapping[str, object], column: str) -> object:
    """Return a column, or an entry within a column of JSON; None if it is missing."""
    name, *path = column.split(".")
    value = row.get(name)
    if path and isinstance(value, str):
        value = json_strictly(value)
    for part in path:
        value = value.get(part) if isinstance(value, dict) else None
    return value


def _set(row: JsonObject, path: Sequence[str], value: object) -> None:
    name, *inner = path
    if not inner:
        row[name] = value
        return
    text = isinstance(row.get(name), str)
    whole = json_strictly(row[name]) if text else dict(row.get(name) or {})
    at = whole
    for part in inner[:-1]:
        at[part] = dict(at[part]) if isinstance(at.get(part), dict) else {}
        at = at[part]
    at[inner[-1]] = value
    row[name] = dumps(whole, ensure_ascii=False) if text else whole
