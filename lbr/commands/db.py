"""`lbr db`: init, add, remove, check, table, diff, audit and restore, and the subcommands of other modules."""

import datetime as dt
from pathlib import Path

import click

from lbr import home
from lbr.capability import registry
from lbr.commands import row_apply, row_past
from lbr.commands.completing import of_rows
from lbr.commands.options import FileName, complete_robot, database_option, json_option, print_json
from lbr.commands.row_past import local_time
from lbr.commands.row_touched import Touching, change_rows
from lbr.commands.rows import judged, opened
from lbr.database import changes, copies
from lbr.database import restore as restoring
from lbr.database.shipped import differences
from lbr.errors import InputError
from lbr.executive.planning import joining
from lbr.executive.planning.watch import loaded
from lbr.messages.plain import one_line
from lbr.messages.rows import short


@click.group("db")
def command() -> None:
    """Create, check, compare and restore robots' rows. Edit them with any SQLite client; a running robot follows."""


@command.command("init")
@database_option
@click.option("--sql", type=FileName(exists=True, dir_okay=False), help="Instead of the rows of all robots.")
def init(database: Path | None, sql: Path | None) -> None:
    """Create the database with the rows of all robots (see 'lbr robots'); a file that is there is left alone."""
    path = database or home.default_database()
    for left_out in joining.create(path, sql):
        click.echo(f"left out: {left_out}", err=True)
    click.echo(f"created {path}")


@command.command("add")
@click.argument("robot", shell_complete=complete_robot)
@database_option
@json_option
def add(robot: str, database: Path | None, as_json: bool) -> None:
    """Add the rows of ROBOT's package that are missing in the database; others stay as they are.

    A robot that is newer than the database is also added at its first run; new rows of a known robot only by this
    command.
    """
    with opened(database) as rows:
        added = joining.add(rows, robot.replace("-", "_"))
    if as_json:
        print_json(added)
    elif added:
        click.echo(f"added to {rows.path}: " + ", ".join(f"{count} of {table}" for table, count in added.items()))
    else:
        click.echo(f"all rows that {robot} brings are in {rows.path}")


@command.command("remove")
@click.argument("robot", shell_complete=of_rows("robot", "description"))
@click.option("--dry-run", is_flag=True, help="Show the effects, and write nothing.")
@database_option
@json_option
def remove(robot: str, dry_run: bool, database: Path | None, as_json: bool) -> int:
    """Remove all rows of ROBOT, which must not run; 'lbr db undo' brings them back, and 'lbr db add' those of its
    package. Tokens, events and the audit trail stay."""
    with opened(database) as rows:
        rows.robots(robot)
        touching, text = Touching(rows), f"removed robot '{robot}'"
        removed = change_rows(
            rows, lambda now, of: changes.between(now, {}, of, robot), text, touching, dry_run=dry_run
        )
    how = row_past.Changing(robot, expected=None, dry_run=dry_run, database=database, as_json=as_json)
    return row_past.tell(removed, f"'{robot}' is removed", how)


@command.command("check")
@database_option
@click.option("--robot", metavar="NAME", help="Check one robot alone.")
@json_option
def check(database: Path | None, robot: str | None, as_json: bool) -> int:
    """Check the rows of every robot, as a start would, and the audit trail. Exit code 2 if anything is bad. A hint is
    an oddity that does not keep a robot from running."""
    with opened(database) as rows:
        all_rows = loaded(rows, rows.robots(robot))
        both = {name: judged(of_robot) for name, of_robot in all_rows.items()}
        problems = {name: bad for name, (bad, _) in both.items()}
        hints = {name: odd for name, (_, odd) in both.items()}
        if not problems:
            raise InputError(f"{rows.path} has no robot row")
        if fault := rows.audit_fault():
            problems["audit"] = [f"the audit trail is not whole: {fault}"]
        if foreign := rows.foreign():
            hints["schema"] = list(foreign)
    if as_json:
        told = [*problems, *(name for name in hints if name not in problems)]
        print_json([{"robot": one, "problems": problems.get(one, []), "hints": hints.get(one, [])} for one in told])
    else:
        _tell(problems, hints)
    return 2 if any(problems.values()) else 0


@command.command("table")
@click.argument("kind")
def table(kind: str) -> None:
    """Print the SQL of the tables that capabilities of KIND read, with the triggers that keep their changes."""
    from lbr.database import schema

    click.echo("\n".join(schema.script(read.row) for read in registry.find(kind, home.home()).reads), nl=False)


def _tell(problems: dict[str, list[str]], hints: dict[str, list[str]]) -> None:
    for name, found in problems.items():
        for problem in found:
            click.echo(f"{short(name)}: {problem}", err=True)
        if not found:
            click.echo(f"{short(name)}: good")
    for name, odd in hints.items():
        for hint in odd:
            click.echo(f"{short(name)}: hint: {hint}")


@command.command("diff")
@click.argument("first", type=click.IntRange(0), required=False, metavar="[A]")
@click.argument("second", type=click.IntRange(0), required=False, metavar="[B]")
@database_option
@json_option
def diff(first: int | None, second: int | None, database: Path | None, as_json: bool) -> int:
    """Show what differs from the rows that lbr and the robots' packages bring. Exit code 0 either way.

    With revision A, show what has changed since then; with A and B, from one to the other (see 'lbr db history').
    """
    with opened(database) as rows:
        differing = differences(rows) if first is None else row_past.between(rows, first, second)
    if as_json:
        print_json(differing)
        return 0
    for difference in differing:
        click.echo(str(difference))
    if not differing:
        click.echo("the rows are as shipped" if first is None else "nothing differs")
    return 0


@command.command("audit")
@database_option
@click.option("-n", "count", type=click.IntRange(1), default=50, show_default=True, help="How many of the newest.")
@json_option
def audit(database: Path | None, count: int, as_json: bool) -> int:
    """Show who did what to the robot: the newest entries of the audit trail. Exit code 2 if it was tampered with."""
    with opened(database) as rows:
        entries, fault = rows.audit(count), rows.audit_fault()
    if as_json:
        print_json(entries)
    for entry in () if as_json else entries:
        at = local_time(entry.wall_ns / 1e9)
        click.echo(one_line(f"{at} {entry.source} {entry.kind} {entry.subject}: {entry.text}"))
    if fault:
        click.echo(f"the audit trail is not whole: {fault}", err=True)
    return 2 if fault else 0


@command.command("restore")
@click.argument("source", required=False, metavar="[FROM]", type=FileName(exists=True, dir_okay=False))
@database_option
@click.option("--list", "only_list", is_flag=True, help="Only show the copies that are kept.")
@json_option
def restore(source: Path | None, database: Path | None, only_list: bool, as_json: bool) -> int:
    """Replace the database by the last good copy, or by the backup FROM; the old one is kept beside it.

    A running robot copies its rows whenever they have run well for some seconds. Shut it down first. Revoked tokens
    stay revoked, unless their rows are damaged, too; the valid ones are listed.
    """
    path = database or home.default_database()
    if only_list:
        stored = copies.stored(path)
        if as_json:
            print_json(stored)
        for copy in () if as_json else stored:
            click.echo(f"{copy.path}: {copy.kept_at}, {copy.fault or f'revision {copy.revision}'}")
        if not stored and not as_json:
            click.echo(f"no copy of {path} is kept")
        return 0
    chosen, aside = restoring.restore(path, source)
    if as_json:
        print_json({"database": str(path), "from": str(chosen), "before": str(aside) if aside else None})
    else:
        click.echo(f"restored {path} from {chosen}" + (f"; what was there before is {aside}" if aside else ""))
        if tokens := _valid_tokens(path):
            click.echo(
                f"tokens that are valid in it: {', '.join(tokens)}; 'lbr token revoke NAME' whom you locked out since"
            )
    return 0


def _valid_tokens(path: Path) -> list[str]:
    now = dt.datetime.now(dt.UTC)
    with opened(path) as rows:
        return [one.name for one in rows.tokens() if one.revoked_at is None and not one.has_expired(now)]


for _one in (*row_past.COMMANDS, *row_apply.COMMANDS):
    command.add_command(_one)
