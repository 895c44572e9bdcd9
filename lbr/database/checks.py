"""What is wrong with a robot's rows: every problem at once, each with its table, row and column."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from lbr.database import builtin, decode, patterns
from lbr.database.decode import Read
from lbr.database.reader import RowReader, json_strictly, shown
from lbr.database.rows import Faulty, JointRow, Problem, RobotRow, RobotRows, VerbRow
from lbr.database.tables import KEYS, RawRow, RawTables

EXECUTIVE = "executive"
"""What verbs and channels may have as their target without a row of its own: lbr itself."""

BUILT_IN = "is a word that every robot has, and no row changes: drop this row, or choose another word"

_READ: dict[str, tuple[str, Callable[[RowReader, RawRow], Any]]] = {
    "capability": ("capabilities", decode.capability),
    "channel": ("channels", decode.channel),
    "device": ("devices", decode.device),
    "verb": ("verbs", decode.verb),
    "external_command": ("external_commands", decode.external_command),
    "phrase": ("phrases", decode.phrase),
    "choreography": ("choreographies", decode.choreography),
    "calibration": ("calibrations", decode.calibration),
    "joint": ("joints", decode.joint),
    "motion": ("motions", decode.motion),
    "motion_step": ("motion_steps", decode.motion_step),
    "motor": ("motors", decode.motor),
    "button": ("buttons", decode.button),
}
"""Each table's field of RobotRows, and how its rows are read."""


def check(tables: RawTables, robot: str, *, revision: int = 0, problems: Iterable[Problem] = ()) -> RobotRows:
    """Decode and check one robot's rows; never raises, whatever is in the tables."""
    found = list(problems)
    own = {table: _of_robot(table, tables, robot, found) for table in KEYS if table != "robot"}
    itself = _robot(tables.get("robot", ()), robot, found)
    read = {table: decode.decode(table, own[table], reading, found) for table, (_, reading) in _READ.items()}
    _Between(read, own, found).check()
    good: dict[str, Any] = {
        field: tuple(one.row for one in read[table] if not one.wrong) for table, (field, _) in _READ.items()
    }
    return RobotRows(
        robot=itself,
        revision=revision,
        problems=tuple(found),
        faulty=tuple(
            Faulty(one.table, one.label, one.row, frozenset(one.wrong))
            for rows in read.values()
            for one in rows
            if one.wrong
        ),
        **good,
    )


def _robot(raw: Sequence[RawRow], robot: str, problems: list[Problem]) -> RobotRow:
    mine = [values for values in raw if values.get("name") == robot]
    if not mine:
        known = ", ".join(sorted(shown(values.get("name")) for values in raw)) or "none"
        add = f"; if it ships with lbr, `lbr db add {shown(robot)}` adds its rows"
        problems.append(Problem("robot", robot, "name", f"there is no robot of this name (there is: {known}){add}"))
    good = [one.row for one in decode.decode("robot", mine, decode.robot, problems) if not one.wrong]
    return good[0] if good else RobotRow(name=robot)


def _of_robot(table: str, tables: RawTables, robot: str, problems: list[Problem]) -> list[RawRow]:
    """Return the robot's rows of a table, and note rows that belong to no robot at all."""
    rows = tables.get(table, ())
    if "robot" not in KEYS[table]:
        return list(rows)
    robots = [values.get("name") for values in tables.get("robot", ())]
    for values in rows:
        owner = values.get("robot")
        if owner not in robots:
            key = "/".join(shown(values.get(column)) for column in KEYS[table])
            problems.append(Problem(table, key, "robot", f"there is no robot '{shown(owner)}'"))
    return [values for values in rows if values.get("robot") == robot]


class _Between:
    """The checks between rows, those with a fault too: two faults of one row are told at once.

    What a row names is looked up in the raw rows, so that no row is told of the fault of another.
    """

    def __init__(self, read: Mapping[str, tuple[Read, ...]], raw: RawTables, problems: list[Problem]) -> None:
        self._read = read
        self._problems = problems
        self._names = {
            table: {values.get("name") for values in raw[table]}
            for table in ("capability", "device", "joint", "motion")
        }

    def check(self) -> None:
        """Note what is wrong with rows that are good by themselves, or in these columns."""
        self._needs()
        self._cycles()
        self._used_devices()
        self._wiring()
        self._targets()
        self._same_lines()
        self._same_servos()
        self._motions()

    def _rows(self, table: str, *columns: str) -> Iterator[tuple[Read, Any]]:
        """Yield the rows of a table of which these columns could be read."""
        return ((one, one.row) for one in self._read[table] if one.unread.isdisjoint(columns))

    def _wrong(self, one: Read, column: str, text: str) -> None:
        one.wrong.add(column)
        self._problems.append(Problem(one.table, one.label, column, text))

    def _needs(self) -> None:
        for one, row in self._rows("capability", "needs"):
            for needed in row.needs:
                if needed not in self._names["capability"]:
                    self._wrong(one, "needs", f"there is no capability '{shown(needed)}'")

    def _cycles(self) -> None:
        """Note every capability that needs itself, if only by way of others."""
        needs = {row.name: row.needs for _, row in self._rows("capability", "name", "needs")}
        for one, row in self._rows("capability", "name", "needs"):
            seen: set[str] = set()
            ahead = list(row.needs)
            while ahead:
                needed = ahead.pop()
                if needed not in seen:
                    seen.add(needed)
                    ahead.extend(needs.get(needed, ()))
            if row.name in seen:
                self._wrong(one, "needs", "it needs itself, by way of what it needs")

    def _used_devices(self) -> None:
        for one, row in self._rows("capability", "settings"):
            device = json_strictly(row.settings).get("device")
            if isinstance(device, str) and device not in self._names["device"]:
                self._wrong(one, "settings", f"device: there is no device '{shown(device)}'")
        for one, row in self._rows("calibration", "device"):
            if row.device not in self._names["device"]:
                self._wrong(one, "device", f"there is no device '{row.device}'")

    def _wiring(self) -> None:
        for column in ("source", "target"):
            for one, row in self._rows("channel", column):
                name, _ = row.source_end if column == "source" else row.target_end
                known = name in self._names["capability"] or (column == "target" and name == EXECUTIVE)
                if not known:
                    self._wrong(one, column, f"there is no capability '{name}'")

    def _targets(self) -> None:
        for one, row in self._rows("verb", "target"):
            name, _ = row.target_end
            if name != EXECUTIVE and name not in self._names["capability"]:
                self._wrong(one, "target", f"there is no capability '{name}'")

    def _same_lines(self) -> None:
        said: dict[tuple[str, ...], VerbRow] = {}
        for one, row in self._rows("verb", "word", "pattern"):
            pattern = patterns.parse(row.pattern)
            if builtin.shadowed(pattern):
                self._wrong(one, "word", f"'{row.word}' {BUILT_IN}")
                continue
            first = said.setdefault(pattern.shape, row)
            if first is not row:
                self._wrong(one, "pattern", f"takes the same lines as '{first.pattern}'")
        for one, command in self._rows("external_command", "name"):
            if builtin.taken(command.name):
                self._wrong(one, "name", f"'{command.name}' {BUILT_IN}")
            elif (command.name,) in said:
                self._wrong(one, "name", f"'{command.name}' is a verb already")

    def _same_servos(self) -> None:
        servos: dict[int, str] = {}
        for one, row in self._rows("joint", "name", "device_id"):
            first = servos.setdefault(row.device_id, row.name)
            if first != row.name:
                self._wrong(one, "device_id", f"servo {row.device_id} moves joint '{first}' already")

    def _motions(self) -> None:
        for column in ("lead_in", "lead_out"):
            for one, row in self._rows("motion", column):
                other = row.lead_in if column == "lead_in" else row.lead_out
                if other and (other not in self._names["motion"] or other == row.name):
                    self._wrong(one, column, f"there is no other motion '{other}'")
        for one, row in self._rows("button", "motion"):
            if row.motion and row.motion not in self._names["motion"]:
                self._wrong(one, "motion", f"there is no motion '{row.motion}'")
        for one, row in self._rows("motion_step", "motion"):
            if row.motion not in self._names["motion"]:
                self._wrong(one, "motion", f"there is no motion '{row.motion}'")
        joints = {row.name: row for _, row in self._rows("joint", "name", "lower_rad", "upper_rad")}
        for one, row in self._rows("motion_step", "positions"):
            for name, angle in row.positions.items():
                self._angle(one, joints.get(name), name, angle)

    def _angle(self, one: Read, joint: JointRow | None, name: str, angle: float) -> None:
        if name not in self._names["joint"]:
            self._wrong(one, "positions", f"there is no joint '{shown(name)}'")
        elif joint is not None and not joint.lower_rad <= angle <= joint.upper_rad:
            text = f"{name}: {angle:g} is outside {joint.lower_rad:g} to {joint.upper_rad:g}, the joint's limits"
            self._wrong(one, "positions", text)
