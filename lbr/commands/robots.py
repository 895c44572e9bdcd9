"""`lbr robots`."""

import click

from lbr import plugins
from lbr.commands.options import json_option, print_json
from lbr.executive.planning import joining, profile
from lbr.robot import registry


@click.command("robots")
@json_option
def command(as_json: bool) -> int:
    """List the robots that lbr and installed packages bring, and with what 'lbr run' starts each.

    A robot of a package that cannot be used is told with the reason; the others run. Needs no running robot.
    """
    found = [(one, joining.fault(one)) for one in registry.every()]
    if as_json:
        print_json(
            [
                {
                    "name": one.name,
                    "package": one.package,
                    "summary": one.robot.summary if one.robot is not None else "",
                    "profiles": profile.of_robot(one),
                    "fault": fault,
                }
                for one, fault in found
            ]
        )
        return 0
    for one, fault in found:
        if one.robot is not None and not fault:
            click.echo(f"{one.name}: {one.robot.summary} ({one.package})")
            click.echo("".join(f"  lbr run {name}\n" for name in profile.of_robot(one)), nl=False)
        else:
            click.echo(f"{one.name}: cannot be used: {fault}", err=True)
    for why in plugins.broken():
        click.echo(why, err=True)
    return 0
