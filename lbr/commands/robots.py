"""`lbr robots`."""

import click

from lbr import plugins
from lbr.commands.options import json_option, print_json
from lbr.executive.planning import joining, profile
from lbr.robot import registry


@click.command("robots")
@json_option
def command(as_json: bool) -> int:
    """List the robots of lbr and of installed packages, and the launch profiles of each for 'lbr run'. An unusable
    robot is listed with the reason; the others run. Needs no running robot."""
    robots = [(robot, joining.fault(robot)) for robot in registry.every()]
    if as_json:
        print_json(
            [
                {
                    "name": robot.name,
                    "package": robot.package,
                    "summary": robot.robot.summary if robot.robot is not None else "",
                    "profiles": profile.of_robot(robot),
                    "fault": fault,
                }
                for robot, fault in robots
            ]
        )
        return 0
    for robot, fault in robots:
        if robot.robot is not None and not fault:
            click.echo(f"{robot.name}: {robot.robot.summary} ({robot.package})")
            click.echo("".join(f"  lbr run {name}\n" for name in profile.of_robot(robot)), nl=False)
        else:
            click.echo(f"{robot.name}: cannot be used: {fault}", err=True)
    for why in plugins.broken():
        click.echo(why, err=True)
    return 0
