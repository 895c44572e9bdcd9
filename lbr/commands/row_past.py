"""`lbr db history`, `rollback` and `undo`: earlier rows, the authors of changes, and the return to them."""

import time
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import click
from click.shell_completion import CompletionItem
from msgspec.structs import asdict

from lbr.commands.options import complete_robot, database_option, json_option, print_json, together
from lbr.commands.row_touched import Touched, Touching, change_rows, end_left_trial
from lbr.commands.rows import opened
from lbr.database import changes, past
from lbr.database.changes import Change
from lbr.database.difference import Difference
from lbr.database.past import HistoryEntry
from lbr.database.proposals import Proposed
from lbr.database.reading import Problem, RawTables
from lbr.database.rows import RevisionRow
from lbr.database.shipped import shipped
from lbr.database.tables import Schema
from lbr.database.trials import Trial
from lbr.errors import InputError
from lbr.messages.plain import one_line
from lbr.resources import robot_db_sql

if TYPE_CHECKING:
    from lbr.database.store import Database


def complete_table(_context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the tables whose changes are kept, for completion."""
    return [CompletionItem(name) for name in shipped(robot_db_sql())[1] if name.startswith(begun)]


class Changing(NamedTuple):
    """A change of rows by a command: the robot, the revision that it began with, and whether it is written."""

    robot: str | None
    expected: int | None
    dry_run: bool
    database: Path | None
    as_json: bool


change_options = together(
    "how",
    Changing,
    click.option("--robot", metavar="NAME", shell_complete=complete_robot, help="Change the rows of one robot alone."),
    click.option(
        "--revision",
        "expected",
        type=click.IntRange(0),
        metavar="N",
        help="Refuse if the rows have changed since this revision.",
    ),
    click.option("--dry-run", is_flag=True, help="Show the effects, and write nothing."),
    database_option,
    json_option,
)


@click.command("history")
@click.option(
    "-n", "count", type=click.IntRange(1), default=20, show_default=True, help="How many of the newest changes."
)
@click.option("--robot", metavar="NAME", shell_complete=complete_robot, help="Changes of one robot's rows.")
@click.option("--table", metavar="TABLE", shell_complete=complete_table, help="Changes of one table's rows.")
@click.option("--row", metavar="ROW", help="Changes of one row, by its name: lbr/drive, or drive.")
@database_option
@json_option
def history(
    count: int, robot: str | None, table: str | None, row: str | None, database: Path | None, as_json: bool
) -> int:
    """Show the changes of rows, with author, time and program, the newest last.

    The numbers are revisions: 'lbr db diff A B' compares two, 'lbr db rollback REV' goes back to one.
    """
    with opened(database) as rows:
        if table is not None and table not in (known := rows.tables()[1]):
            raise InputError(f"no table '{table}' keeps its changes: {', '.join(sorted(known))}", "unknown_name")
        changes = rows.changes()
    asked = []
    for change in changes:
        mine = [revision for revision in change.rows if _is_asked(revision, robot, table, row)]
        if mine:
            asked.append((change, [past.of_revision(revision) for revision in mine]))
    asked = asked[-count:]
    if as_json:
        print_json([{**asdict(change), "rows": lines} for change, lines in asked])
        return 0
    for change, lines in asked:
        click.echo(one_line(f"{_numbers(change)}  {_local(change.at)}  {_author(change)}"))
        for line in lines:
            click.echo(one_line(f"    {line}"))
    if not asked:
        click.echo("no such row was changed" if robot or table or row else "no row was changed")
    return 0


@click.command("rollback")
@click.argument("number", type=click.IntRange(0), metavar="REV")
@change_options
def rollback(number: int, how: Changing) -> int:
    """Change the rows back to revision REV; 'lbr db undo' takes that back. All of them or none: exit code 2 with the
    problems, and nothing is changed. The emergency stop, tokens and the audit trail stay as they are. A running robot
    follows."""
    with opened(how.database) as rows:
        proposed = go_back(rows, number, how)
    return tell(proposed, f"the rows are as at revision {number}", how)


@click.command("undo")
@click.argument("count", type=click.IntRange(1), default=1, metavar="[N]")
@change_options
def undo(count: int, how: Changing) -> int:
    """Take back the newest change of rows, or the newest N; 'undo' once more takes that back.

    A change is one entry of 'lbr db history'. With --robot, the newest ones of that robot's rows: later changes of
    other rows stay.
    """
    with opened(how.database) as rows:
        if not how.dry_run and (taken_back := end_left_trial(rows)):
            if count > 1:
                raise InputError(f"{taken_back}: look at 'lbr db history', and say 'lbr db undo' again", "changed")
            click.echo(taken_back)
            return 0
        changes = rows.changes()
        mine = [one for one in changes if any(_is_asked(row, how.robot, None, None) for row in one.rows)]
        if len(mine) < count:
            raise InputError(f"there are {len(mine)} changes to take back, not {count}", "not_possible")
        expected = changes[-1].last if how.expected is None else how.expected
        proposed = go_back(rows, mine[-count].first - 1, how._replace(expected=expected))
    which = "the newest change is" if count == 1 else f"the newest {count} changes are"
    return tell(proposed, f"{which} taken back", how)


COMMANDS = (history, rollback, undo)


def go_back(rows: "Database", number: int, how: Changing) -> Proposed:
    """Change the rows back to those of a revision; raise InputError if that is not possible."""
    robot = how.robot

    def wanted(tables: RawTables, schema: Schema) -> tuple[Change, ...]:
        return changes.between(tables, rows.tables_at(number), schema, robot)

    try:
        rows.robots(robot)
    except InputError:  # there may have been a robot of this name
        if not any(one.row_key[:1] == (robot,) for one in rows.revisions() if one.table == "robot"):
            raise
    text = f"went back to revision {number}" + (f" of '{robot}'" if robot else "")
    return change_rows(rows, wanted, text, Touching(rows), how.expected, dry_run=how.dry_run)


def between(rows: "Database", first: int, second: int | None) -> tuple[Difference, ...]:
    """Return the differences between two revisions; without a second one, to the present rows."""
    now, schema = rows.tables()
    after = now if second is None else rows.tables_at(second)
    return changes.differences(changes.between(rows.tables_at(first), after, schema))


def tell(
    proposed: Proposed,
    done: str,
    how: Changing,
    *,
    touched: tuple[Touched, ...] = (),
    place: Callable[[Problem], str] = str,
    trial: Trial | None = None,
) -> int:
    """Print the result of a proposal, and return the exit code: 2 if problems kept the rows unchanged."""
    differences = changes.differences(proposed.changes)
    written = not (how.dry_run or proposed.problems or not proposed.changes)
    if how.as_json:
        print_json(
            {
                "written": written,
                "before": proposed.before,
                "revision": proposed.revision,
                "differences": differences,
                "problems": proposed.problems,
                "touched": touched,
                "trial": trial,
            }
        )
        return 2 if proposed.problems else 0
    for difference in differences:
        click.echo(one_line(str(difference)))
    for problem in proposed.problems:
        click.echo(f"problem: {one_line(place(problem))}", err=True)
    if proposed.problems:
        click.echo("nothing was changed", err=True)
        return 2
    for robot in touched:
        click.echo(one_line(str(robot)))
    if not differences:
        click.echo("nothing differs: nothing was changed")
    elif how.dry_run:
        click.echo(f"nothing was changed yet; the rows have revision {proposed.before}")
    elif trial is not None and trial.state != "kept":
        click.echo(
            f"went back to revision {trial.back}: {trial.text}" if trial.state == "back" else trial.text, err=True
        )
    else:
        click.echo(f"{done}: revision {proposed.revision}")
    return 0


def local_time(seconds: float) -> str:
    """Return a time in this machine's zone, for people."""
    return time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(seconds))


def _is_asked(revision: RevisionRow, robot: str | None, table: str | None, row: str | None) -> bool:
    """Return whether a revision is of a robot, of a table and of a row; None matches all."""
    values = revision.after or revision.before or {}
    mine = robot is None or values.get("name" if revision.table == "robot" else "robot") == robot
    keys = {"/".join(revision.row_key), "/".join(revision.row_key[1:])}
    return mine and table in {None, revision.table} and (row is None or row in keys)


def _numbers(change: HistoryEntry) -> str:
    return str(change.last) if change.first == change.last else f"{change.first}-{change.last}"


def _author(change: HistoryEntry) -> str:
    if not change.program:
        return change.text
    return f"{change.source}, {change.program}" + (f": {change.text}" if change.text else "")


def _local(at: str) -> str:
    try:
        return local_time(datetime.fromisoformat(at).timestamp())
    except ValueError:  # another SQLite client may have written it
        return at
