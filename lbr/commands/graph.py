"""`lbr graph`."""

from pathlib import Path

import click

from lbr.commands.options import json_option, print_json


@click.command("graph")
@click.option("--robot", metavar="NAME", help="Which robot; the one that runs here, or the only one in the rows.")
@click.option("--db", "database", type=click.Path(path_type=Path), metavar="FILE", help="The rows; those of the robot.")
@click.option(
    "--dot", "as_dot", is_flag=True, help="Print the graph for Graphviz: lbr graph --dot | dot -Tsvg > robot.svg"
)
@json_option
def command(robot: str | None, database: Path | None, as_dot: bool, as_json: bool) -> int:
    """Show who feeds whom, from the rows; with states and rates if the robot runs here."""
    from lbr import home  # noqa: PLC0415 - only now is the database needed
    from lbr.commands.rows import opened, robot_in  # noqa: PLC0415
    from lbr.console import wiring  # noqa: PLC0415

    here = [one for one in home.running() if robot in {None, one.robot}]
    record = here[0] if len(here) == 1 and database in {None, Path(here[0].database)} else None
    path = database or (Path(record.database) if record else home.default_database())
    with opened(path) as rows:
        loaded = rows.load(robot or (record.robot if record else robot_in(rows)))
    states, rates = _running(record)
    found = wiring.graph(loaded, states, rates)
    if as_json:
        print_json(wiring.plain(found))
        return 0
    for line in wiring.dot(found) if as_dot else wiring.tree(found):
        click.echo(line)
    return 0


def _running(record: object) -> tuple[dict[str, str], dict[str, float]]:
    from lbr import home  # noqa: PLC0415
    from lbr.commands.status import ask  # noqa: PLC0415
    from lbr.console import target  # noqa: PLC0415
    from lbr.errors import BusError  # noqa: PLC0415

    if not isinstance(record, home.Running):
        return {}, {}
    try:
        status = ask(target.find(record.robot, None), "lbr graph")
    except BusError:
        return {}, {}
    states = {one.name: str(one.phase) for one in status.capabilities}
    rates = {f"{one.name}.{out}": hz for one in status.capabilities for out, hz in one.rates_hz.items()}
    return states, rates
