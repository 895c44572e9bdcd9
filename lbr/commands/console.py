"""`lbr console`."""

import click

from lbr.commands.options import Number, Whom, robot_options
from lbr.console import local, target


@click.command("console")
@robot_options
@click.option(
    "--hold",
    "hold_s",
    type=Number(0.0, 30.0),
    metavar="SECONDS",
    help="For lines from a pipe: hold each unbounded motion this long. Without it a motion is held until a later line "
    "moves or stops the robot, or the input ends.",
)
def command(whom: Whom, hold_s: float | None) -> int:
    """Open a console on a running robot.

    End of input, Ctrl-C and a closed terminal stop this console's motions, and leave; the robot runs on. Lines may also
    come from a pipe; empty ones and those that begin with # are skipped. Results go to standard output, errors to
    standard error, and the exit code is the worst line's. Once somebody else stops the robot, lines that were already
    waiting are dropped.
    """
    return local.run_remote(target.find(*whom), hold_s=hold_s)
