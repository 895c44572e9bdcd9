"""Finds all faults of a robot's rows at once, each with its table, row and column."""

from collections.abc import Iterable, Mapping

from lbr.database.reading import ROBOT, Problem, RawTables, Tables
from lbr.database.rows import (
    CORE,
    CapabilityRow,
    ChannelRow,
    DeviceRow,
    ExternalCommandRow,
    Faulty,
    RobotRow,
    RobotRows,
    VerbRow,
)
from lbr.messages.rows import Row, short


def check(
    raw: RawTables,
    robot: str,
    *,
    revision: int = 0,
    problems: Iterable[Problem] = (),
    columns: Mapping[str, Iterable[str]] | None = None,
    also: Iterable[type[Row]] = (),
) -> RobotRows:
    """Decode and check one robot's rows, with `also` some tables of its kinds; never raises, whatever their content."""
    tables = Tables(raw, robot, columns or {})
    faults = [*problems]
    itself = _robot(raw, tables, robot, faults)
    rows: tuple[type[Row], ...] = (*CORE[1:], *also)
    for row in rows:
        faults += tables.problems(row)
    return RobotRows(
        robot=itself,
        capabilities=tables.good(CapabilityRow),
        channels=tables.good(ChannelRow),
        devices=tables.good(DeviceRow),
        verbs=tables.good(VerbRow),
        external_commands=tables.good(ExternalCommandRow),
        tables=tables,
        revision=revision,
        problems=tuple(faults),
        faulty=tuple(
            Faulty(row.TABLE, read.label, read.row, frozenset(read.wrong))
            for row in CORE[1:]
            for read in tables.rows(row)
            if read.wrong
        ),
    )


def _robot(raw: RawTables, tables: Tables, robot: str, problems: list[Problem]) -> RobotRow:
    robots = [values.get("name") for values in raw.get(ROBOT, ())]
    if robot not in robots:
        known = ", ".join(sorted(map(short, robots))) or "none"
        add = f"; if a package brings it, `lbr db add {short(robot)}` adds its rows"
        problems.append(Problem("robot", robot, "name", f"there is no robot of this name (there is: {known}){add}"))
    problems += tables.problems(RobotRow)
    good = tables.good(RobotRow)
    return good[0] if good else RobotRow(name=robot)
