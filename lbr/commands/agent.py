"""`lbr agent`."""

from pathlib import Path

import click

from lbr import surroundings
from lbr.commands.options import FileName
from lbr.console.outlet import unhurried
from lbr.errors import InputError
from lbr.executive.remote.agent import Agent


@click.command("agent")
@click.argument("host")
@click.option(
    "--connect", required=True, metavar="ENDPOINT", help="Where the robot listens, such as tls/192.168.1.7:7447."
)
@click.option("--robot", metavar="NAME", help="Which robot it must be; whichever is there if left out.")
@click.option(
    "--token-file",
    type=FileName(),
    metavar="FILE",
    help="Holds the host's token. Else it is LBR_TOKEN, a saved one, or asked for.",
)
def command(host: str, connect: str, robot: str | None, token_file: Path | None) -> int:
    """Run a share of a robot on another machine: the parts that its launch profile places on HOST.

    The token comes from 'lbr token add HOST --role host' at the robot. Processes start here, with their logs below this
    machine's LBR_HOME. When contact is lost or the robot shuts down they end, and the agent waits for the robot to come
    back. SIGTERM and Ctrl-C end it.
    """
    if not host:
        raise InputError("HOST is empty: give the name of this machine in the robot's launch profile")
    surroundings.forget_runtime()
    surroundings.bound_heaps()
    surroundings.need_room_for_a_robot()
    with unhurried():
        return Agent(host, connect, token_file, robot, click.echo).run()
