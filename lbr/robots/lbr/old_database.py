"""The database of this robot's first program, and the place of its rows here."""

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from json import loads
from pathlib import Path
from typing import Any, NamedTuple

from lbr.errors import InputError
from lbr.messages.rows import short
from lbr.names import name_from
from lbr.robot.old_data import Choice, ForeignTables, Here, Note, OldData, Source, Want, no_place

_SAME = {"robot_process", "channel", "extcmd", "calibration", "move_config"}
"""Most of these tables are present; other programs have tables `robot`, too."""
_WITHOUT = {
    "robot_process": "the rows of capability list the processes",
    "channel": "the rows of channel wire capabilities and ports",
    "message": "the original never spoke them; the robot's phrases are in phrase",
    "ai_notes": "they were for a language model, which lbr lacks",
}
_HARD, _SOFT = ("MAG_ALPHA", "MAG_BETA"), ("MAG_COR0", "MAG_COR1", "MAG_COR2", "MAG_COR3")
_NAMES = dict(
    zip(
        (*_HARD, *_SOFT),
        ("mag_offset_x_ut", "mag_offset_y_ut", "mag_matrix_00", "mag_matrix_01", "mag_matrix_10", "mag_matrix_11"),
        strict=True,
    )
)
_UNKNOWN_TIME = "1970-01-01T00:00:00.000Z"
_KNOWN = {"navcam": "navcam", "docksignal": "docksignal", "autodock": "autodock"}
"""Programs of the original that exist here under these words."""
_WIDEST_CM, _MOST_COUNTS = 200.0, 1_000_000


class OldDatabase(NamedTuple):
    """The tables of the original's database."""

    tables: ForeignTables
    folder: str

    def fits(self, target: Here) -> bool:
        """Return whether a robot has the wheels of the original."""
        return any(row["kind"] == "odometry" for row in target.rows("capability"))

    def wants(self, target: Here, choice: Choice) -> Iterator[Want | Note]:
        """Yield the changes by the rows of one of its robots."""
        robot = _chosen(self.tables, target, choice)
        yield from _robot(robot, target)
        yield from _calibration(self._of(robot, "calibration"), target)
        for row in self._of(robot, "move_config"):
            yield from _wheels(row, target)
        for row in self._of(robot, "extcmd"):
            yield from _command(row, target, self.folder)
        yield from self._others(robot)

    def _of(self, robot: Mapping[str, object], table: str) -> list[Mapping[str, object]]:
        return [row for row in self.tables.get(table, ()) if row.get("robot_id") == robot["robot_id"]]

    def _others(self, robot: Mapping[str, object]) -> Iterator[Note]:
        names = {row.get("robot_id"): row.get("name") for row in self.tables["robot"]}
        for table, rows in self.tables.items():
            if table == "robot":
                for row in rows:
                    if row is not robot:
                        yield no_place(table, short(row.get("name")), "", "one robot is taken at a time: --of names it")
            elif table in {"calibration", "move_config", "extcmd"}:
                others = sorted({short(row.get("robot_id")) for row in rows if row.get("robot_id") not in names})
                if others:
                    text = "rows of a robot that is not there, by which the original switched them off"
                    yield no_place(table, f"robot_id {', '.join(others)}", "", text)
            elif rows:
                text = _WITHOUT.get(table, "the original has no such table")
                yield no_place(table, f"{len(rows)} row{'s' if len(rows) != 1 else ''}", "", text)


def read(source: Source) -> OldData | None:
    """Return the original's database, as a file or as SQL; None for another database."""
    tables = source.tables()
    if tables is None or len(_SAME & set(tables)) < len(_SAME) - 2:
        return None
    robots = tables.get("robot", ())
    if not robots or not {"robot_id", "name"} <= set(robots[0]):
        return None
    return OldDatabase(tables, source.folder)


def _chosen(tables: ForeignTables, target: Here, choice: Choice) -> Mapping[str, object]:
    robots = tables["robot"]
    model = next((row["model"] for row in target.rows("robot")), "")
    wanted = choice.of or (model if len(robots) > 1 else robots[0]["name"])
    named = [row for row in robots if row["name"] == wanted]
    if len(named) != 1:
        names = ", ".join(short(row["name"]) for row in robots)
        raise InputError(f"it has the robots {names}: say which with --of NAME")
    return named[0]


def _robot(row: Mapping[str, Any], target: Here) -> Iterator[Want | Note]:
    name = short(row["name"])
    told = {column: str(row[column]) for column in ("owner",) if row.get(column)}
    (own,) = (one["name"] for one in target.rows("robot"))
    yield Want("robot", {"name": own}, {"model": str(row["name"]), **told}, f"robot '{name}'")
    for column, text in (
        ("type", "every robot of that program had the same"),
        ("url", "the original never used it"),
        ("last_start_time", "lbr writes down its own starts"),
        ("last_shutdown_time", "lbr writes down its own ends"),
    ):
        if row.get(column):
            yield no_place("robot", name, column, text)


def _calibration(rows: Sequence[Mapping[str, Any]], target: Here) -> Iterator[Want | Note]:
    values: dict[str, float] = {}
    for row in rows:
        name, value = short(row.get("name")), row.get("value")
        if name not in _NAMES:
            yield no_place("calibration", name, "value", "the original never read it")
        elif not isinstance(value, int | float) or not math.isfinite(value):
            yield no_place("calibration", name, "value", f"'{short(value)}' is not a finite number")
        else:
            if name in values:
                yield Note(
                    "changed", "calibration", name, "value", f"it stands there twice: {value:g} counts, the last one"
                )
            values[name] = float(value)
    if not values:
        return
    soft = [name for name in _SOFT if name in values]
    kind, unit = ("riox", "a RIOX") if soft else ("mpu9150", "an MPU-9150")
    devices = [one["name"] for one in target.rows("device") if one["type"] == kind]
    missing = [name for name in (*_HARD, *(_SOFT if soft else ())) if name not in values]
    if missing or len(devices) != 1:
        such = f"{len(devices)} devices here are such" if devices else "no device here is such"
        why = f"{', '.join(missing)} are missing" if missing else f"it is of {unit}, and {such}"
        for name in values:
            yield no_place("calibration", name, "value", f"{why}: /m/200 measures it here")
        return
    for name, value in values.items():
        key = {"device": devices[0], "name": _NAMES[name]}
        made = {"measured_at": _UNKNOWN_TIME}
        yield Want("calibration", key, {"value": value}, f"calibration '{name}'", create=True, made=made)
    turned = "; the original turned it by -29.375 degrees more, which stands in its program" if soft else ""
    text = f"taken along the same axes, which is unverified{turned}: /m/200 measures it here"
    yield Note("changed", "calibration", ", ".join(values), "value", text)


def _wheels(row: Mapping[str, object], target: Here) -> Iterator[Want | Note]:
    name = short(row.get("robot_id"))
    odometry = [one["name"] for one in target.rows("capability") if one["kind"] == "odometry"]
    counted = bool(target.rows("wheel"))
    for column, setting, factor, most in (
        ("wheel_diameter", "wheel_diameter_m", 0.01, _WIDEST_CM),
        ("counts_per_rev", "counts_per_turn", 1, _MOST_COUNTS),
    ):
        value = row.get(column)
        if not isinstance(value, int | float) or not 0 < value <= most:
            text = (
                f"'{short(value)}' is unknown: the original had no such sensor"
                if value == 0
                else f"'{short(value)}' cannot be"
            )
            yield no_place("move_config", name, column, text)
        elif len(odometry) != 1 or (counted and setting == "wheel_diameter_m"):
            text = "rows of wheel say it here" if counted else "there is no odometry here, or several"
            yield no_place("move_config", name, column, text)
        else:
            scaled = round(value * factor, 6) if factor != 1 else value
            source = f"move_config '{name}', {column}"
            yield Want("capability", {"name": odometry[0]}, {f"settings.{setting}": scaled}, source)
    for channel in (1, 2, 3, 4):
        column = f"m{channel}_direction"
        value = row.get(column)
        wheel = _wheel(target, channel)
        if not value:
            continue
        if value not in {1, -1} or wheel is None:
            text = (
                "no wheel of this robot is on that channel"
                if value in {1, -1}
                else f"'{short(value)}' is neither 1 nor -1"
            )
            yield no_place("move_config", name, column, text)
            continue
        motors, side = wheel
        yield Want(
            "capability",
            {"name": motors},
            {f"settings.{side}.channel": channel, f"settings.{side}.direction": value},
            f"move_config '{name}', {column}",
            text="the original kept it and drove by a fixed one: try it with the wheels off the floor",
        )


def _wheel(target: Here, channel: int) -> tuple[str, str] | None:
    """Return the capability of the motor controller, and the side of one of its channels."""
    for row in target.rows("capability"):
        if row["kind"] == "roboteq":
            settings = loads(row["settings"])
            for side, usual in (("left", 1), ("right", 2)):
                if (settings.get(side) or {}).get("channel", usual) == channel:
                    return row["name"], side
    return None


def _command(row: Mapping[str, object], target: Here, folder: str) -> Iterator[Want | Note]:
    word, program = short(row.get("cmd_name")), str(row.get("target") or "")
    if word in _KNOWN and any(one["name"] == _KNOWN[word] for one in target.rows("external_command")):
        yield no_place("extcmd", word, "target", f"'{_KNOWN[word]}' is here already, as a program of lbr")
        return
    path = Path(program) if Path(program).is_absolute() else Path(os.path.abspath(Path(folder) / program))  # noqa: PTH100
    if not program or "\0" in program or not (path.is_file() and os.access(path, os.X_OK)):
        text = f"'{short(program)}' is no program that is there: a row of external_command names one by its whole path"
        yield no_place("extcmd", word, "target", text)
        return
    name = name_from(word, "command")
    for column in ("stdin", "stdout", "stderr"):
        if row.get(column) is not None:
            yield no_place("extcmd", word, column, "output goes to the log of the command, or to the console")
    arguments = [part for part in str(row.get("args") or "").split(" ") if part]
    columns = {"argv": [str(path), *arguments], "blocking": bool(row.get("blocking"))}
    text = "switched off: look at what it starts, then set enabled to 1"
    yield Want(
        "external_command", {"name": name}, columns, f"extcmd '{word}'", create=True, text=text, made={"enabled": False}
    )
