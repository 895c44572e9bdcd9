"""`lbr phone`."""

import click

from lbr.commands import send
from lbr.commands.options import Whom, json_option, robot_options

START_S = 10.0


@click.command("phone")
@robot_options
@json_option
@click.pass_context
def command(context: click.Context, whom: Whom, as_json: bool) -> int:
    """Connect a phone to a running robot: open its page to your network, and show one code to scan.

    The code is good for two minutes and one device, which may then drive. `lbr send close` closes the page again. Says
    the console's word `phone`, which needs the role admin.
    """
    options = {"robot": whom.robot, "connect": whom.connect, "token_file": whom.token_file}
    return int(context.invoke(send.command, words=("phone",), **options, hold_s=0.0, wait_s=START_S, as_json=as_json))
