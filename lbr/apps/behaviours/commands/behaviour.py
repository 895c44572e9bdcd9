"""`lbr behaviour`: state tables from spreadsheets and back, checked, drawn, and run."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from lbr import home
from lbr.apps.behaviours import drawing, files, keys, outputs, texts
from lbr.apps.behaviours.commands import trials as behaviour_trials
from lbr.apps.behaviours.files import Read
from lbr.apps.behaviours.keys import EVERY
from lbr.apps.behaviours.table import (
    ANY_ROBOT,
    Compiled,
    Fault,
    Parts,
    cell_faults,
    compile_table,
    compiled_alone,
    linked,
)
from lbr.apps.behaviours.texts import fault as fault_text
from lbr.commands.completing import complete_behaviour
from lbr.commands.new_file import write_new
from lbr.commands.options import FileName, Whom, database_option, json_option, print_json, robot_options
from lbr.commands.rows import opened, problems_of, robot_in, wiring_of
from lbr.database import edits, given_files
from lbr.database.rows import RobotRows
from lbr.errors import InputError, RowError
from lbr.messages.behaviour import BehaviourRow, BehaviourState, BehaviourTable
from lbr.messages.plain import one_line
from lbr.messages.sensing import RING, RangeSensor
from lbr.messages.units import NAME_PATTERN
from lbr.names import name_from

robot_option = click.option("--robot", metavar="NAME", help="Whose behaviours; the usual robot's if left out.")


@click.group("behaviour")
def command() -> None:
    """Write state tables in a spreadsheet, check and take them, and run them. A running robot follows an edit."""


@command.command("check")
@click.argument("source", metavar="FILE|TABLE")
@robot_option
@database_option
def check(source: str, robot: str | None, database: Path | None) -> int:
    """Say all that is wrong with a table in FILE (CSV or JSON) or in the robot's rows, with line, column and what to
    do."""
    if not _is_a_file(source):
        rows = _rows(database, robot)
        table, compiled = _table(rows, source), _compiled(rows)[source]
        _complain(f"behaviour '{table.name}'", compiled.faults, {})
        if compiled.errors:
            raise RowError(tuple(f"behaviour '{table.name}', {fault_text(one)}" for one in compiled.errors))
        click.echo(f"{source}: good")
        return 0
    path = Path(source)
    read = _read(path, "behaviour")
    of_robot = _rows_if_any(database, robot)
    compiled = _fits(path, BehaviourTable(name=_name_of(path)), read, of_robot)
    _complain(str(path), compiled.faults, read.lines)
    states = len(compiled.table.states) if compiled.table is not None else 0
    click.echo(f"{path}: good: {len(read.rows)} rows, {states} states")
    return 0


@command.command("import")
@click.argument("file", type=FileName(dir_okay=False))
@click.option("--name", metavar="NAME", help="What it is to be called; as the file if left out.")
@click.option("--help-text", "text", metavar="TEXT", help="What it is for, in one line.")
@click.option(
    "--max",
    "max_s",
    type=click.FloatRange(0.0, 86400.0),
    metavar="SECONDS",
    help="The longest it may run; 0: until it ends.",
)
@click.option("--replace", "replacing", is_flag=True, help="Put it in the place of the table that has this name.")
@robot_option
@database_option
@json_option
def import_(
    file: Path,
    name: str | None,
    text: str | None,
    max_s: float | None,
    replacing: bool,
    robot: str | None,
    database: Path | None,
    as_json: bool,
) -> int:
    """Take the table in FILE, CSV or JSON, as a behaviour of the robot; one with a fault is refused, and all are named.

    A robot that runs has it at once. If it is the one that is being run, its states count from when they are next
    entered.
    """
    called = name or _name_of(file)
    if not re.fullmatch(NAME_PATTERN, called) or len(called) > 40:
        raise InputError(f"'{called}' is not a name: small letters, digits and _, a letter first; give one by --name")
    with opened(database) as db:
        whose = robot_in(db, robot)
        rows = db.load(whose)
        before = next((one for one in rows.of(BehaviourTable) if one.name == called), None)
        if before is not None and not replacing:
            how = "--replace puts this one in its place, --name gives it another name"
            raise InputError(f"behaviour '{called}' is there already: {how}", "exists")
        former = before or BehaviourTable(name=called)
        table = BehaviourTable(
            name=called,
            help=former.help if text is None else text,
            max_s=former.max_s if max_s is None else max_s,
        )
        read = _read(file, called)
        compiled = _fits(file, table, read, rows)
        _complain(str(file), compiled.faults, read.lines)
        edits.write_rows(db, whose, (table, *read.rows), problems_of, create=None).good()
    if as_json:
        print_json({"robot": whose, "name": called, "rows": len(read.rows)})
    else:
        click.echo(f"took '{called}' for {whose}: {len(read.rows)} rows; 'lbr behaviour run {called}' runs it")
    return 0


@command.command("export")
@click.argument("table", shell_complete=complete_behaviour)
@click.option("--csv", "form", flag_value="csv", default=True, help="For a spreadsheet; the default.")
@click.option("--json", "form", flag_value="json", help="As JSON.")
@click.option(
    "--semicolons", is_flag=True, help="CSV with semicolons, as spreadsheets want it where numbers have commas."
)
@click.option("--to", "path", type=FileName(), metavar="FILE", help="Else it is printed.")
@robot_option
@database_option
def export(table: str, form: str, semicolons: bool, path: Path | None, robot: str | None, database: Path | None) -> int:
    """Write a TABLE as CSV or JSON, for a spreadsheet or for others; 'lbr behaviour import' takes it."""
    _, rows = _stored(table, robot, database)
    if form == "json":
        content = files.to_json(rows)
    else:
        text = files.to_csv(rows, ";" if semicolons else ",")
        content = text.encode("utf-8-sig" if path is not None else "utf-8")  # the mark tells Excel that it is UTF-8
    if path is None:
        click.echo(content.decode().replace("\r\n", "\n"), nl=False)
        return 0
    write_new(path, content)
    return 0


@command.command("show")
@click.argument("table", shell_complete=complete_behaviour)
@click.option("--svg", is_flag=True, help="As a picture, for a browser.")
@click.option("--to", "path", type=FileName(), metavar="FILE", help="Else it is printed.")
@robot_option
@database_option
def show(table: str, svg: bool, path: Path | None, robot: str | None, database: Path | None) -> int:
    """Draw the states of a TABLE, and what leads from one to the next."""
    of_table, rows = _stored(table, robot, database)
    drawn = drawing.svg(of_table, rows) if svg else texts.graph(of_table, rows) + "\n"
    if path is None:
        click.echo(drawn, nl=False)
        return 0
    write_new(path, drawn.encode())
    return 0


@command.command("list")
@robot_option
@database_option
def list_(robot: str | None, database: Path | None) -> int:
    """List the behaviours in the robot's rows, and what is wrong with those that cannot be run."""
    rows = _rows(database, robot)
    tables = {one.name: one for one in rows.of(BehaviourTable)}
    click.echo(texts.listed(tables, _compiled(rows), BehaviourState(phase="resting")))
    return 0


@command.command("columns")
def columns() -> int:
    """List the columns that a condition may have: names of the telemetry, and of the run itself."""
    click.echo("as tables have always had them, distances in centimetres:\n  " + ", ".join(keys.COLUMNS))
    click.echo("any of the telemetry, by its last name where only one has it:")
    for name in keys.all_names():
        click.echo(f"  {name}")
    click.echo("outputs:\n  " + ", ".join(f"O:{name}" for name in outputs.ALL))
    return 0


@command.command("try")
@behaviour_trials.options
def try_(source: str, robot: str | None, database: Path | None, *, as_json: bool, **given: Any) -> int:
    """Try a table in FILE, or one of the robot's, in its simulated world: from anywhere, with noise, and nothing moves.

    The robot's own drive, beacon, battery and odometry do as they do when it runs; what drivers measure is simulated. A
    table that is still under way after its time counts as good. Exit code 1 if a trial failed or was not safe.
    """
    return behaviour_trials.tries(source, *chosen(source, robot, database), as_json=as_json, **given)


def _word(name: str, text: str) -> None:
    """Add a subcommand that sends one console word to a running robot."""

    @click.command(name, help=text)
    @robot_options
    @json_option
    @click.pass_context
    def say(context: click.Context, whom: Whom, as_json: bool) -> object:
        return _send(context, f"/behaviour/{name}", whom, as_json=as_json)

    command.add_command(say)


@command.command("run")
@click.argument("table", shell_complete=complete_behaviour)
@click.option("--wait", is_flag=True, help="Wait for its end, and print how it ended; exit code 1 if not well.")
@robot_options
@json_option
@click.pass_context
def run(context: click.Context, table: str, whom: Whom, wait: bool, as_json: bool) -> object:
    """Have a running robot run TABLE from its start; it goes on without this command, and 'lbr behaviour stop' ends
    it."""
    return _send(context, f"/behaviour/run/{table}", whom, as_json=as_json, wait=wait)


for _name, _text in (
    ("stop", "End the behaviour that runs, and stand still."),
    ("pause", "Stand still; resume goes on."),
    ("step", "After a pause: go on up to the next state, and pause there."),
    ("resume", "Go on after a pause."),
    ("why", "Say where the run is, and for each row what does not hold and by how much."),
):
    _word(_name, _text)


def _send(context: click.Context, line: str, whom: Whom, *, as_json: bool, wait: bool = False) -> object:
    from lbr.apps.behaviours.commands import running  # noqa: PLC0415 - the bus is for those who use it

    code = running.send_line(context, line, whom, as_json=as_json)
    return running.wait_for_end(whom, as_json=as_json) if wait and code == 0 else code


def chosen(
    source: str, robot: str | None, database: Path | None
) -> tuple[RobotRows, BehaviourTable, tuple[BehaviourRow, ...]]:
    """Return a robot's rows, and a table that can be run: of a FILE, or the robot's own by its name."""
    rows = _rows(database, robot)
    if _is_a_file(source):
        path = Path(source)
        table = BehaviourTable(name=_name_of(path))
        read = _read(path, table.name)
        _complain(source, _fits(path, table, read, rows).faults, read.lines)
        return rows, table, read.rows
    table = _table(rows, source)
    if errors := _compiled(rows)[source].errors:
        raise RowError(tuple(f"behaviour '{source}', {fault_text(one)}" for one in errors))
    return rows, table, tuple(row for row in rows.of(BehaviourRow) if row.behaviour == source)


def _is_a_file(source: str) -> bool:
    return not re.fullmatch(NAME_PATTERN, source) or Path(source).is_file()


def _name_of(path: Path) -> str:
    return name_from(path.stem.removesuffix(".states"), "table")


def _read(path: Path, name: str) -> Read:
    """Return the rows of a file and its faults."""
    content = given_files.read(path, files.LARGEST_BYTES)
    return files.read(content, name, json=path.suffix.lower() == ".json")


def _fits(path: Path, table: BehaviourTable, read: Read, rows: RobotRows | None) -> Compiled:
    """Return a file's table, checked beside the robot's own; raise RowError with all faults. If cells are unreadable,
    only cells are checked, as the states are incomplete."""
    parts = _parts(rows)
    if read.faults:
        problems = [(fault.line, f"{path}, {fault}") for fault in read.faults]
        problems += [
            (read.lines.get(fault.step, 0), _located(str(path), fault, read.lines))
            for fault in cell_faults(read.rows, parts)
        ]
        raise RowError(tuple(one_line(text) for _, text in sorted(problems, key=lambda problem: problem[0])))
    alone = _alone(rows, parts) if rows is not None else {}
    compiled = {**alone, table.name: compile_table(table, read.rows, parts)}
    mine = (linked(compiled) if rows is not None else compiled)[table.name]
    if mine.errors:
        raise RowError(tuple(one_line(_located(str(path), fault, read.lines)) for fault in mine.errors))
    return mine


def _complain(where: str, faults: tuple[Fault, ...], lines: Mapping[int, int]) -> None:
    """Print the notes; errors are raised elsewhere."""
    for one in faults:
        if not one.error:
            click.echo(one_line(f"note: {_located(where, one, lines)}"), err=True)


def _located(where: str, fault: Fault, lines: Mapping[int, int]) -> str:
    """Return a fault after the name of its file or table."""
    return f"{where}{', ' if fault.step or fault.column else ': '}{fault_text(fault, lines)}"


def _compiled(rows: RobotRows) -> dict[str, Compiled]:
    return linked(_alone(rows, _parts(rows)))


def _alone(rows: RobotRows, parts: Parts) -> dict[str, Compiled]:
    """Return every table of a robot, each checked by itself."""
    return compiled_alone(rows.of(BehaviourTable), rows.of(BehaviourRow), parts)


def _parts(rows: RobotRows | None) -> Parts:
    """Return the parts of a robot that tables use; of any robot if there are no rows or no capability runs tables."""
    wired = wiring_of(rows, "behaviour") if rows is not None else None
    if rows is None or wired is None:
        return ANY_ROBOT
    sensors = frozenset(row.name for row in rows.of(RangeSensor)) or frozenset(RING)
    return Parts(wired & EVERY, wired - EVERY, sensors)


def _stored(table: str, robot: str | None, database: Path | None) -> tuple[BehaviourTable, tuple[BehaviourRow, ...]]:
    rows = _rows(database, robot)
    of_table = _table(rows, table)
    return of_table, tuple(row for row in rows.of(BehaviourRow) if row.behaviour == table)


def _table(rows: RobotRows, name: str) -> BehaviourTable:
    tables = {one.name: one for one in rows.of(BehaviourTable)}
    if name not in tables:
        there = ", ".join(sorted(tables)) or "none"
        raise InputError(f"{rows.robot.name} has no behaviour '{name}': there is {there}", "unknown_name")
    return tables[name]


def _rows(database: Path | None, robot: str | None) -> RobotRows:
    with opened(database) as there:
        return there.load(robot_in(there, robot))


def _rows_if_any(database: Path | None, robot: str | None) -> RobotRows | None:
    """Return a robot's rows to check a file by; None without the default database, unless another is named."""
    if database is None and robot is None and not home.default_database().exists():
        return None
    return _rows(database, robot)
