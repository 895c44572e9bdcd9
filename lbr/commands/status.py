"""`lbr status`."""

import click
import msgspec

from lbr.bus import keys, wire
from lbr.commands.options import Whom, json_option, print_json, robot_options
from lbr.commands.status_table import show
from lbr.console import target
from lbr.console.target import Target
from lbr.errors import BusError
from lbr.messages.system import Status


@click.command("status")
@robot_options
@json_option
def command(whom: Whom, as_json: bool) -> int:
    """Show every capability of a running robot: state, process, restarts, rates and the reason if it is not ready."""
    status = ask(target.find(*whom), "lbr status")
    if as_json:
        print_json(status)
    else:
        show(status)
    return 0


def ask(robot: Target, who: str) -> Status:
    """Return a robot's status; BusError if it does not answer."""
    with target.connected(robot) as bus:
        answers = wire.ask(bus, keys.status(robot.robot), None, source=target.source(who))
    if not answers:
        raise BusError(f"robot '{robot.robot}' does not answer")
    return msgspec.json.decode(answers[0].payload, type=Status)
