"""`lbr graph`."""

from pathlib import Path

import click

from lbr import home
from lbr.commands.options import FileName, Whom, json_option, print_json, robot_options
from lbr.commands.rows import opened, robot_in, with_words
from lbr.commands.speaking import speaking
from lbr.commands.status import ask
from lbr.console import target, wiring
from lbr.console.wiring import Graph
from lbr.errors import BusError, InputError


@click.command("graph")
@robot_options
@click.option("--db", "database", type=FileName(), metavar="FILE", help="The rows; those of the robot.")
@click.option(
    "--dot", "as_dot", is_flag=True, help="Print the graph for Graphviz: lbr graph --dot | dot -Tsvg > robot.svg"
)
@json_option
def command(whom: Whom, database: Path | None, as_dot: bool, as_json: bool) -> int:
    """Show who feeds whom, from the rows; with states and rates if the robot runs."""
    if whom.connect and database is not None:
        raise InputError("--db is for rows here, and --connect for a robot elsewhere; leave out one")
    wires = _elsewhere(whom) if whom.connect else _graph_here(whom.robot, database)
    if as_json:
        print_json(wires)
        return 0
    for line in wiring.dot(wires) if as_dot else wiring.tree(wires):
        click.echo(line)
    return 0


def _elsewhere(whom: Whom) -> Graph:
    with speaking(target.find(*whom), "lbr graph") as said:
        result = said.submit("/report/wiring")
    if result.code != 0:
        raise BusError(result.text)
    return wiring.from_plain(result.data)


def _graph_here(robot: str | None, database: Path | None) -> Graph:
    here = [one for one in home.running() if robot in {None, one.robot}]
    record = here[0] if len(here) == 1 and database in {None, Path(here[0].database)} else None
    path = database or (Path(record.database) if record else home.default_database())
    with opened(path) as rows:
        loaded = rows.load(robot_in(rows, record.robot if record and robot is None else robot))
    return wiring.graph(with_words(loaded), *_running(record))


def _running(record: object) -> tuple[dict[str, str], dict[str, float]]:
    if not isinstance(record, home.Running):
        return {}, {}
    try:
        return wiring.running(ask(target.find(record.robot, None), "lbr graph"))
    except BusError:
        return {}, {}
