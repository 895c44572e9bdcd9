"""`lbr import`: the files of a robot's former programs become its rows, with a report of values without a place."""

from collections.abc import Sequence
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from lbr.apps.motions.commands import old_files, wanted_rows
from lbr.apps.motions.commands.motion_files import MotionFile
from lbr.apps.motions.commands.old_files import Given
from lbr.apps.motions.commands.wanted_rows import Imported, RowsOfRobot
from lbr.commands.options import FileName, complete_robot, database_option, json_option, print_json
from lbr.commands.rows import opened, problems_of
from lbr.database import edits, given_files
from lbr.database.rows import RobotRows
from lbr.database.shipped import shipped
from lbr.database.store import Database
from lbr.errors import InputError
from lbr.messages.joints import Joint, Motion
from lbr.messages.plain import one_line
from lbr.robot.old_data import Choice, Note, Want, merged

_SHOWN = {"added": "added", "changed": "changed", "clamped": "clamped", "no_place": "no place"}


def _complete_format(_context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    return [CompletionItem(name, help=text) for name, text in old_files.formats().items() if name.startswith(begun)]


@click.command("import")
@click.argument("path", type=FileName(), metavar="FILE|FOLDER")
@click.option("--robot", metavar="NAME", shell_complete=complete_robot, help="Whose rows; found out if left out.")
@click.option(
    "--as",
    "wanted",
    metavar="FORMAT",
    shell_complete=_complete_format,
    help="What the file is, such as rbm, mtn or lbr-database; found out if left out.",
)
@click.option("--of", metavar="NAME", help="Which robot of the file, if it has several.")
@click.option("--replace", "replacing", is_flag=True, help="Also write over what is not as shipped.")
@click.option("--dry-run", is_flag=True, help="Show the effects, and write nothing; all is checked.")
@database_option
@json_option
def command(
    path: Path,
    robot: str | None,
    wanted: str | None,
    of: str | None,
    replacing: bool,
    dry_run: bool,
    database: Path | None,
    as_json: bool,
) -> int:
    """Take what a robot's former programs kept: their databases, tables and motions, from a file or all of a folder.

    All of it is written, or nothing, as one edit that a running robot follows. A value that is not as shipped is a
    person's. If a file differs, it is named and nothing is written, unless --replace is given. The report names each
    value that was changed, brought within limits or has no place here.
    """
    with opened(database) as rows:
        if wanted is not None and wanted not in (known := old_files.formats()):
            raise InputError(f"there is no format '{wanted}': {', '.join(known)}", "unknown_name")
        given, others = _given(path, wanted)
        whose = _robot(rows, robot, given)
        of_robot = rows.load(whose)
        plan = _planned(rows, whose, of_robot, given, Choice(of), replacing=replacing)
        plan = _write(rows, whose, plan, of_robot.revision, dry_run=dry_run)
    notes = (*plan.notes, *others)
    written = bool(plan.rows) and not dry_run
    if as_json:
        print_json(
            {
                "robot": whose,
                "files": [{"file": str(one.path), "format": one.format} for one in given],
                "written": written,
                "rows": len(plan.rows),
                "report": [note._asdict() for note in notes],
            }
        )
        return 0
    _report(whose, given, plan, notes, dry_run=dry_run)
    return 0


def _given(path: Path, wanted: str | None) -> tuple[list[Given], list[Note]]:
    """Read a file, or each file of a folder; return the known ones, and notes about the others."""
    if not path.is_dir():
        found = old_files.understood(path, wanted)
        if found.why:
            raise InputError(f"{path}: {found.why}")
        return [found], []
    files, others = given_files.listed(path)
    every = [old_files.understood(file, wanted) for file in files]
    notes = [Note("no_place", "file", file.path.name, "", file.why) for file in every if file.why]
    notes += [
        Note("no_place", "file", file.name, "", "only files that lie in the folder itself are read") for file in others
    ]
    if not (known := [file for file in every if not file.why]):
        raise InputError(f"{path} has no file of a format that is known: {', '.join(old_files.formats())}")
    return known, notes


def _robot(rows: Database, robot: str | None, given: Sequence[Given]) -> str:
    """Return the chosen robot, or the only one that all files fit."""
    names = rows.robots(robot.replace("-", "_") if robot is not None else None)
    if robot is not None:
        return names[0]
    tables, _ = rows.tables()
    loaded = rows.load_all(names)
    fitting = [name for name in names if all(_fits(one, RowsOfRobot(tables, name), loaded[name]) for one in given)]
    if len(fitting) != 1:
        raise InputError(f"{len(fitting)} robots fit it ({', '.join(fitting) or 'none'}); say which with --robot NAME")
    return fitting[0]


def _fits(given: Given, present: RowsOfRobot, rows: RobotRows) -> bool:
    if isinstance(given.motions, MotionFile):
        named = {name for frame in given.motions.motion.frames for name in frame.positions}
        if any(row["name"] == given.motions.robot for row in present.tables["robot"]):
            return given.motions.robot == present.robot
        return named <= {row.name for row in rows.of(Joint)} != set()
    if given.motions is not None:
        return given.motions.fits(rows)
    return given.data is not None and given.data.fits(present)


def _planned(
    rows: Database,
    robot: str,
    of_robot: RobotRows,
    given: Sequence[Given],
    choice: Choice,
    *,
    replacing: bool,
) -> Imported:
    """Return the rows that all files together would write; raise InputError for a person's rows in the way."""
    tables, _ = rows.tables()
    present = wanted_rows.RowsOfRobot(tables, robot)
    wants: list[Want] = []
    motions: list[Motion] = []
    notes: list[Note] = []
    for file in given:
        try:
            if isinstance(file.motions, MotionFile):
                motions.append(file.motions.motion)
            elif file.motions is not None:
                some, more = file.motions.motions(of_robot)
                motions += some
                notes += more
            elif file.data is not None:
                for wish in file.data.wants(present, choice):
                    if isinstance(wish, Want):
                        wants.append(wish)
                    else:
                        notes.append(wish)
        except InputError as err:
            raise InputError(f"{file.path}: {err}") from err
    first, _ = shipped()
    imported = (
        wanted_rows.take(wants, present, first, replacing=replacing),
        wanted_rows.take_motions(motions, of_robot, first, replacing=replacing),
    )
    if conflicts := [text for part in imported for text in part.conflicts]:
        more_of = f", and {len(conflicts) - 10} more" if len(conflicts) > 10 else ""
        raise InputError(
            f"settings of a person would be overwritten: {'; '.join(conflicts[:10])}{more_of}. Nothing is written; "
            "--replace takes those of the file"
        )
    return wanted_rows.Imported(
        rows=tuple(row for part in imported for row in part.rows),
        notes=(*(note for part in imported for note in part.notes), *notes),
    )


def _write(rows: Database, robot: str, plan: Imported, revision: int, *, dry_run: bool) -> Imported:
    """Write the rows of a plan that the robot accepts; return the plan without the others."""
    while plan.rows:
        proposed = edits.write_rows(
            rows, robot, plan.rows, problems_of, create=None, revision=revision, dry_run=dry_run
        )
        accepted = wanted_rows.without(plan, robot, proposed.problems)
        if accepted.rows == plan.rows:
            proposed.good()  # raises if the problem is in other rows
            break
        plan = accepted
    return plan


def _report(robot: str, given: Sequence[Given], plan: Imported, notes: Sequence[Note], *, dry_run: bool) -> None:
    names = ", ".join(f"{one.path.name} ({one.format})" for one in given[:10])
    took = "would take" if dry_run else "took"
    count = f"{len(plan.rows)} row{'s' if len(plan.rows) != 1 else ''}"
    click.echo(f"{took} {count} for {robot} from {names}" + (f" and {len(given) - 10} more" if len(given) > 10 else ""))
    for kind, said in _SHOWN.items():
        for note in merged(note for note in notes if note.kind == kind):
            click.echo(one_line(f"{said}: {note}"))
    if same := sum(note.kind == "same" for note in notes):
        click.echo(f"as it was already: {same}")
