"""What is wrong with a robot's rows: every problem at once, each with its table, row and column."""

from collections.abc import Iterable, Sequence

import msgspec
from msgspec import Struct

from lbr.database import builtin, decode, patterns
from lbr.database.reader import json_strictly, shown
from lbr.database.rows import JointRow, MotionStepRow, Problem, RobotRow, RobotRows, VerbRow
from lbr.database.tables import KEYS, RawRow, RawTables

EXECUTIVE = "executive"
"""What verbs and channels may have as their target without a row of its own: lbr itself."""

BUILT_IN = "is a word that every robot has, and no row changes: drop this row, or choose another word"

_LISTS = (
    "capabilities",
    "channels",
    "devices",
    "verbs",
    "external_commands",
    "phrases",
    "choreographies",
    "calibrations",
    "joints",
    "motions",
    "motion_steps",
    "motors",
    "buttons",
)


def check(tables: RawTables, robot: str, *, revision: int = 0, problems: Iterable[Problem] = ()) -> RobotRows:
    """Decode and check one robot's rows; never raises, whatever is in the tables."""
    found = list(problems)
    own = {table: _of_robot(table, tables, robot, found) for table in KEYS if table != "robot"}
    rows = RobotRows(
        robot=_robot(tables.get("robot", ()), robot, found),
        capabilities=decode.decode("capability", own["capability"], decode.capability, found),
        channels=decode.decode("channel", own["channel"], decode.channel, found),
        devices=decode.decode("device", own["device"], decode.device, found),
        verbs=decode.decode("verb", own["verb"], decode.verb, found),
        external_commands=decode.decode("external_command", own["external_command"], decode.external_command, found),
        phrases=decode.decode("phrase", own["phrase"], decode.phrase, found),
        choreographies=decode.decode("choreography", own["choreography"], decode.choreography, found),
        calibrations=decode.decode("calibration", own["calibration"], decode.calibration, found),
        joints=decode.decode("joint", own["joint"], decode.joint, found),
        motions=decode.decode("motion", own["motion"], decode.motion, found),
        motion_steps=decode.decode("motion_step", own["motion_step"], decode.motion_step, found),
        motors=decode.decode("motor", own["motor"], decode.motor, found),
        buttons=decode.decode("button", own["button"], decode.button, found),
        revision=revision,
    )
    return _Between(rows, own, found).checked()


def _robot(raw: Sequence[RawRow], robot: str, problems: list[Problem]) -> RobotRow:
    mine = [values for values in raw if values.get("name") == robot]
    if not mine:
        known = ", ".join(sorted(shown(values.get("name")) for values in raw)) or "none"
        add = f"; if it ships with lbr, `lbr db add {shown(robot)}` adds its rows"
        problems.append(Problem("robot", robot, "name", f"there is no robot of this name (there is: {known}){add}"))
    decoded = decode.decode("robot", mine, decode.robot, problems)
    return decoded[0] if decoded else RobotRow(name=robot)


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
    """The checks between rows. Rows with a fault are gone already, so names are looked up in the raw rows."""

    def __init__(self, rows: RobotRows, raw: RawTables, problems: list[Problem]) -> None:
        self._rows = rows
        self._problems = problems
        self._capabilities = {values.get("name") for values in raw["capability"]}
        self._devices = {values.get("name") for values in raw["device"]}
        self._bad: set[int] = set()

    def checked(self) -> RobotRows:
        """Return the rows that pass, with all problems."""
        self._needs()
        self._cycles()
        self._used_devices()
        self._wiring()
        self._targets()
        self._same_lines()
        self._same_servos()
        self._motions()
        return self._passed()

    def _wrong(self, table: str, row: Struct, column: str, text: str) -> None:
        key = [self._rows.robot.name, *(str(getattr(row, part)) for part in KEYS[table][1:])]
        self._bad.add(id(row))
        self._problems.append(Problem(table, "/".join(key), column, text))

    def _needs(self) -> None:
        for row in self._rows.capabilities:
            for needed in row.needs:
                if needed not in self._capabilities:
                    self._wrong("capability", row, "needs", f"there is no capability '{shown(needed)}'")

    def _cycles(self) -> None:
        """Note every capability that needs itself, if only by way of others."""
        needs = {row.name: row.needs for row in self._rows.capabilities}
        for row in self._rows.capabilities:
            seen: set[str] = set()
            ahead = list(row.needs)
            while ahead:
                needed = ahead.pop()
                if needed not in seen:
                    seen.add(needed)
                    ahead.extend(needs.get(needed, ()))
            if row.name in seen:
                self._wrong("capability", row, "needs", "it needs itself, by way of what it needs")

    def _used_devices(self) -> None:
        for capability in self._rows.capabilities:
            device = json_strictly(capability.settings).get("device")
            if isinstance(device, str) and device not in self._devices:
                self._wrong("capability", capability, "settings", f"device: there is no device '{shown(device)}'")
        for calibration in self._rows.calibrations:
            if calibration.device not in self._devices:
                self._wrong("calibration", calibration, "device", f"there is no device '{calibration.device}'")

    def _wiring(self) -> None:
        for row in self._rows.channels:
            for column, (name, _) in (("source", row.source_end), ("target", row.target_end)):
                known = name in self._capabilities or (column == "target" and name == EXECUTIVE)
                if not known:
                    self._wrong("channel", row, column, f"there is no capability '{name}'")

    def _targets(self) -> None:
        for row in self._rows.verbs:
            name, _ = row.target_end
            if name != EXECUTIVE and name not in self._capabilities:
                self._wrong("verb", row, "target", f"there is no capability '{name}'")

    def _same_lines(self) -> None:
        said: dict[tuple[str, ...], VerbRow] = {}
        for row in self._rows.verbs:
            pattern = patterns.parse(row.pattern)
            if builtin.shadowed(pattern):
                self._wrong("verb", row, "word", f"'{row.word}' {BUILT_IN}")
                continue
            first = said.setdefault(pattern.shape, row)
            if first is not row:
                self._wrong("verb", row, "pattern", f"takes the same lines as '{first.pattern}'")
        for command in self._rows.external_commands:
            if builtin.taken(command.name):
                self._wrong("external_command", command, "name", f"'{command.name}' {BUILT_IN}")
            elif (command.name,) in said:
                self._wrong("external_command", command, "name", f"'{command.name}' is a verb already")

    def _same_servos(self) -> None:
        servos: dict[int, str] = {}
        for row in self._rows.joints:
            first = servos.setdefault(row.device_id, row.name)
            if first != row.name:
                self._wrong("joint", row, "device_id", f"servo {row.device_id} moves joint '{first}' already")

    def _motions(self) -> None:
        joints = {row.name: row for row in self._rows.joints}
        names = {row.name for row in self._rows.motions}
        for row in self._rows.motions:
            for column, other in (("lead_in", row.lead_in), ("lead_out", row.lead_out)):
                if other and (other not in names or other == row.name):
                    self._wrong("motion", row, column, f"there is no other motion '{other}'")
        for button in self._rows.buttons:
            if button.motion and button.motion not in names:
                self._wrong("button", button, "motion", f"there is no motion '{button.motion}'")
        for step in self._rows.motion_steps:
            if step.motion not in names:
                self._wrong("motion_step", step, "motion", f"there is no motion '{step.motion}'")
            for name, angle in step.positions.items():
                self._angle(step, joints.get(name), name, angle)

    def _angle(self, step: MotionStepRow, joint: JointRow | None, name: str, angle: float) -> None:
        if joint is None:
            self._wrong("motion_step", step, "positions", f"there is no joint '{shown(name)}'")
        elif not joint.lower_rad <= angle <= joint.upper_rad:
            text = f"{name}: {angle:g} is outside {joint.lower_rad:g} to {joint.upper_rad:g}, the joint's limits"
            self._wrong("motion_step", step, "positions", text)

    def _passed(self) -> RobotRows:
        changed = {field: self._good(getattr(self._rows, field)) for field in _LISTS}
        return msgspec.structs.replace(self._rows, problems=tuple(self._problems), **changed)

    def _good(self, rows: tuple[Struct, ...]) -> tuple[Struct, ...]:
        return tuple(row for row in rows if id(row) not in self._bad)
