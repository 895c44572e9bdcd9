"""`lbr db plan`, `apply`, `export` and `import`: rows from a file or folder, judged before they are written."""

import time
from pathlib import Path
from typing import Any

import click
from msgspec.structs import replace

from lbr.commands.options import FileName, Number, complete_robot, database_option, json_option, print_json
from lbr.commands.row_past import Changing, change_options, tell
from lbr.commands.row_touched import Touching, change_rows
from lbr.commands.rows import opened, running_here
from lbr.database import row_files, sources, trials
from lbr.database.store import Database
from lbr.database.trials import Trial
from lbr.errors import InputError

LONGEST_S = 600.0
LOOK_S = 0.1
GRACE_S = 5.0
"""Extra time for a robot that stores the end of a trial late, as on a slow disk."""


@click.command("plan")
@click.argument("source", type=FileName())
@click.option("--robot", metavar="NAME", shell_complete=complete_robot, help="Look at the rows of one robot alone.")
@database_option
@json_option
def plan(source: Path, robot: str | None, database: Path | None, as_json: bool) -> int:
    """Show the effects of 'lbr db apply SOURCE': changed rows, problems, and the processes to start, stop and restart.

    SOURCE is a file of SQL that edits rows, a copy of a database, or a folder of 'lbr db export'. Nothing is touched.
    Exit code 2 with problems.
    """
    return _apply(source, Changing(robot, expected=None, dry_run=True, database=database, as_json=as_json))


@click.command("apply")
@click.argument("source", type=FileName())
@click.option(
    "--within",
    "within_s",
    type=Number(0.1, LONGEST_S),
    metavar="SECONDS",
    help="Go back unless all that is touched is ready by then, also if lbr is killed meanwhile. Waits for it.",
)
@change_options
def apply(source: Path, within_s: float | None, how: Changing) -> int:
    """Change the rows as in SOURCE (see 'lbr db plan'), all of them or none. A running robot follows. Exit code 2 if
    the rows would be bad, and nothing is changed; 1 if --within went back."""
    return _apply(source, how, within_s)


@click.command("import")
@click.argument("folder", type=FileName(exists=True, file_okay=False), metavar="DIR")
@change_options
def import_(folder: Path, how: Changing) -> int:
    """Change the rows as in DIR, a folder of 'lbr db export', all of them or none. Exit code 2 with problems.

    Robots with a folder in DIR get exactly these rows; a table without a file stays, and so do other robots.
    """
    return _apply(folder, how)


@click.command("export")
@click.argument("folder", type=FileName(file_okay=False), metavar="DIR")
@click.option("--robot", metavar="NAME", shell_complete=complete_robot, help="Write the rows of one robot alone.")
@database_option
@json_option
def export(folder: Path, robot: str | None, database: Path | None, as_json: bool) -> None:
    """Write the rows into DIR as text that git compares well: a folder for each robot, a file for each table. Existing
    files are overwritten. Tokens, events and the audit trail are left out."""
    with opened(database) as rows:
        rows.robots(robot)
        tables, schema = rows.tables()
        revision = rows.revision()
    files = row_files.written(tables, schema, robot)
    row_files.write(folder, files)
    if as_json:
        print_json({"revision": revision, "files": [str(folder / one.name) for one in files]})
    else:
        folders = len({one.robot for one in files})
        click.echo(f"wrote {len(files)} files of {folders} folders into {folder}: revision {revision}")


COMMANDS = (plan, apply, export, import_)


def _apply(source: Path, how: Changing, within_s: float | None = None) -> int:
    with opened(how.database) as rows:
        if within_s is not None and not running_here(rows.path):
            raise InputError(
                f"no robot runs from {rows.path} that could say whether it is ready: leave --within out", "not_possible"
            )
        touching = Touching(rows)
        wanted, text = sources.wanted(source, rows.path, how.robot), f"applied {source.name}"
        proposed = change_rows(rows, wanted, text, touching, how.expected, within_s, dry_run=how.dry_run)
        trial = None if within_s is None or proposed.revision == proposed.before else _awaited(rows, proposed.revision)
        done, place = f"the rows are those of {source}", _place(source, rows)
        code = tell(proposed, done, how, touched=touching.effects(), place=place, trial=trial)
    return code or (1 if trial is not None and trial.state != "kept" else 0)


def _awaited(rows: Database, revision: int) -> Trial | None:
    """Wait for the end of a trial of rows; the executive goes on alone if this process is killed."""
    trial = trials.newest(rows)
    if trial is not None:
        click.echo(f"revision {revision} is on trial by '{trial.robot}' for {trial.within_s:g} s", err=True)
        until = time.monotonic() + trial.within_s + GRACE_S
        while trial is not None and trial.revision == revision and trial.state == "running":
            if trial.robot not in running_here(rows.path):
                return replace(trial, text="its robot ended: its next start goes back")
            if time.monotonic() >= until:
                return replace(trial, text="its robot does not judge it: 'lbr status' shows its state")
            time.sleep(LOOK_S)
            trial = trials.newest(rows)
    return trial


def _place(source: Path, rows: Database) -> Any:
    """Return a function that adds the file to a problem, if the source is a folder."""
    if not source.is_dir():
        return str
    schema = rows.tables()[1]
    return lambda problem: row_files.place(problem, schema)
