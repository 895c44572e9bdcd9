"""`lbr status`."""

import click
import msgspec
from msgspec.structs import replace

from lbr.bus import keys, wire
from lbr.commands.completing import complete_capability
from lbr.commands.options import Whom, json_option, print_json, refuse_unknown, robot_options
from lbr.commands.speaking import speaking
from lbr.commands.status_table import show
from lbr.console import target
from lbr.console.target import Target
from lbr.errors import BusError
from lbr.messages.system import Status


@click.command("status")
@click.argument("part", required=False, default="", shell_complete=complete_capability)
@robot_options
@json_option
def command(part: str, whom: Whom, as_json: bool) -> int:
    """Show every part of a running robot: state, process, restarts, rates and the reason if it is not ready. Of PART
    alone, also what holds it still."""
    robot = target.find(*whom)
    status = ask(robot, "lbr status")
    if part:
        refuse_unknown(part, (one.name for one in status.capabilities), status.robot)
        status = replace(status, capabilities=tuple(one for one in status.capabilities if one.name == part))
    if as_json:
        print_json(status)
        return 0
    show(status)
    if part:
        with speaking(robot, "lbr status") as speaker:
            click.echo(speaker.submit(f"why {part}").text)
    return 0


def ask(robot: Target, who: str) -> Status:
    """Return a robot's status; BusError if it does not answer."""
    with target.connected(robot) as bus:
        answers = wire.ask(bus, keys.status(robot.robot), None, source=target.source(who))
    if not answers:
        raise BusError(f"robot '{robot.robot}' does not answer")
    return msgspec.json.decode(answers[0].payload, type=Status)
