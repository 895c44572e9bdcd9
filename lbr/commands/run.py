"""`lbr run`."""

from pathlib import Path

import click

from lbr import home, surroundings
from lbr.commands.options import DEFAULT_PROFILE, FileName, complete_profile
from lbr.console.outlet import unhurried
from lbr.executive.planning import profile
from lbr.executive.planning import profile as profiles
from lbr.robot import registry


class RunCommand(click.Command):
    """Names the launch profiles in its help."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """Write the list of launch profiles."""
        with formatter.section("Profiles"):
            formatter.write_dl(
                [
                    (", ".join(profile.of_robot(one)), one.robot.summary if one.robot else one.fault)
                    for one in registry.every()
                ]
            )


@click.command("run", cls=RunCommand)
@click.argument("profile", default=DEFAULT_PROFILE, shell_complete=complete_profile)
@click.option("--db", "database", type=FileName(), metavar="FILE", help="The rows; $LBR_HOME/robot.db if left out.")
@click.option(
    "--listen", multiple=True, metavar="ENDPOINT", help="Also listen here, such as tls/0.0.0.0:7447; may be repeated."
)
@click.option(
    "--no-console",
    is_flag=True,
    help="No prompt: print a JSON line when all is up, or what keeps the robot from being ready.",
)
@click.option("-v", "--verbose", is_flag=True, help="Show at the console what each part reports while it starts.")
def command(profile: str, database: Path | None, listen: tuple[str, ...], no_console: bool, verbose: bool) -> int:
    """Start a robot with launch profile PROFILE (default lbr-sim); 'lbr robots' lists them.

    The console shows the address of the page, the access for a phone, and faults with their cures. A package's robot
    adds its rows to the database at its first run. End of input and Ctrl-C at the console stop the motors and shut the
    robot down in order.
    """
    home.begin()
    surroundings.forget_runtime()
    from lbr.executive.shutdown import leave_for_certain  # noqa: PLC0415
    from lbr.executive.start import run  # noqa: PLC0415

    surroundings.bound_heaps()
    surroundings.need_room_for_a_robot()
    if not no_console:
        profiles.load(profile)  # a wrong profile is reported before a missing package of its console
        surroundings.need_a_console()
    with unhurried():
        code = run(profile, database, listen, console=not no_console, verbose=verbose)
    leave_for_certain()
    return code
