"""`lbr devices`: the plugged-in devices, and the rows with which a robot would use them."""

from pathlib import Path
from typing import Any

import click

from lbr.commands import looking
from lbr.commands.options import Number, complete_robot, database_option, json_option

WAIT_S, LONGEST_WAIT_S = 2.0, 30.0


@click.command("devices")
@click.option(
    "--robot", metavar="NAME", shell_complete=complete_robot, help="Whose rows; the one that runs, if one does."
)
@click.option(
    "--port",
    "ports",
    metavar="PATH",
    multiple=True,
    help="Look here alone: a tty, i2c:BUS, or unix:PATH of a bus. May be repeated.",
)
@click.option("--as", "called", metavar="DEVICE", help="The device row to make or to change; with one --port.")
@click.option("--listen", is_flag=True, help="Ask nothing: no byte is written, and only what talks by itself is known.")
@click.option(
    "--wait",
    "wait_s",
    type=Number(0.1, LONGEST_WAIT_S),
    default=WAIT_S,
    show_default=True,
    metavar="SECONDS",
    help="How long one line is asked, at most.",
)
@click.option("--write", is_flag=True, help="Write the rows that are proposed; 'lbr db undo' takes them back.")
@click.option("--watch", is_flag=True, help="Go on, and report what is plugged in and pulled out.")
@database_option
@json_option
def command(
    robot: str | None, called: str | None, *, listen: bool, wait_s: float, database: Path | None, **how: Any
) -> int:
    """Find the plugged-in devices, identify each, and propose the rows with which a robot uses it.

    Each is identified by its driver's own question, which moves and changes nothing. Devices in use by a running robot
    or another program are not opened. Nothing is written without --write, or a yes at a terminal. Exit code 2 if a
    proposal is bad.
    """
    return looking.run(robot, called, listen=listen, wait_s=wait_s, database=database, **how)
