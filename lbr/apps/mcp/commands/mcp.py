"""`lbr mcp`."""

import click

from lbr.client import aio
from lbr.commands.options import Whom, robot_options
from lbr.errors import InputError


@click.command("mcp")
@robot_options
def command(whom: Whom) -> int:
    """Serve a robot to a language agent, at standard input and output.

    The agent's program starts it: `claude mcp add robot -- lbr mcp`. An agent's motion goes on only while its program
    lives; anybody may stop it. It ends with its input.
    """
    try:
        from lbr.apps.mcp import stdio  # noqa: PLC0415 - it needs an extra
    except ImportError as err:
        raise InputError(f"lbr mcp needs the extra 'mcp' ({err.name} is missing): pip install 'lbr[mcp]'") from err
    stdio.serve(lambda name: aio.connect(whom.robot, at=whom.connect, token_file=whom.token_file, name=name))
    return 0
