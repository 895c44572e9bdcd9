"""`lbr db`: init, check and diff."""

from pathlib import Path

import click

from lbr.commands.options import json_option, print_json


def _file(function: click.decorators.FC) -> click.decorators.FC:
    return click.option(
        "--db", "database", type=click.Path(path_type=Path), metavar="FILE", help="$LBR_HOME/robot.db if left out."
    )(function)


@click.group("db")
def command() -> None:
    """Create, check and compare the robot's rows. Edit them with any SQLite client; a running robot follows."""


@command.command("init")
@_file
@click.option(
    "--sql", type=click.Path(path_type=Path, exists=True, dir_okay=False), help="Instead of the shipped rows."
)
def init(database: Path | None, sql: Path | None) -> int:
    """Create the database with the shipped rows; a file that is there is left alone."""
    from lbr import home  # noqa: PLC0415 - SQLAlchemy is for those who read rows
    from lbr.database import store  # noqa: PLC0415

    path = database or home.default_database()
    store.create(path, sql)
    click.echo(f"created {path}")
    return 0


@command.command("check")
@_file
@click.option("--robot", metavar="NAME", help="Check one robot alone.")
@json_option
def check(database: Path | None, robot: str | None, as_json: bool) -> int:
    """Check the rows of every robot, as a start would: rows, kinds, settings, wiring and verbs. Exit code 2 if bad."""
    from lbr import home  # noqa: PLC0415
    from lbr.commands.rows import opened  # noqa: PLC0415
    from lbr.errors import InputError  # noqa: PLC0415

    with opened(database or home.default_database()) as rows:
        names = rows.robots()
        if robot is not None and robot not in names:
            raise InputError(f"there is no robot '{robot}' in {rows.path}: {', '.join(names) or 'none'}")
        problems = {name: _problems(rows.load(name)) for name in names if robot in {None, name}}
        if not problems:
            raise InputError(f"{rows.path} has no robot row")
    if as_json:
        print_json([{"robot": name, "problems": found} for name, found in problems.items()])
    for name, found in problems.items():
        for problem in () if as_json else found:
            click.echo(f"{name}: {problem}", err=True)
        if not found and not as_json:
            click.echo(f"{name}: good")
    return 2 if any(problems.values()) else 0


@command.command("diff")
@_file
@json_option
def diff(database: Path | None, as_json: bool) -> int:
    """Show what differs from the rows that ship with lbr. Exit code 0 either way."""
    from lbr import home  # noqa: PLC0415
    from lbr.commands.rows import opened  # noqa: PLC0415
    from lbr.database.difference import differences  # noqa: PLC0415

    with opened(database or home.default_database()) as rows:
        found = differences(rows)
    if as_json:
        print_json(found)
        return 0
    for one in found:
        click.echo(str(one))
    if not found:
        click.echo("the rows are as shipped")
    return 0


def _problems(rows: object) -> list[str]:
    from lbr import home  # noqa: PLC0415
    from lbr.database.rows import RobotRows  # noqa: PLC0415
    from lbr.executive import plan  # noqa: PLC0415
    from lbr.executive.profile import Profile  # noqa: PLC0415

    assert isinstance(rows, RobotRows)
    site = plan.Site(home=str(home.home()), endpoints=(), secret=bytes(32))
    _, problems = plan.make(rows, Profile(robot=rows.robot.name, simulate=True), site)
    return [str(problem) for problem in problems]
