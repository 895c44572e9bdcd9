"""`lbr new`."""

from pathlib import Path

import click

from lbr.commands import scaffold
from lbr.commands.options import FileName
from lbr.commands.scaffold import What


def _place(function: click.decorators.FC) -> click.decorators.FC:
    named = click.argument("name")
    into = click.option(
        "--into",
        type=FileName(file_okay=False),
        default=".",
        metavar="FOLDER",
        help="Where the folder NAME is made; here if left out.",
    )
    return named(into(function))


@click.group("new")
def command() -> None:
    """Write a package of your own that runs at once, in simulation: a robot, a driver, servos, wheels or a capability.

    It is a folder NAME with a project file, a module, rows, a launch profile, tests and a page, and yours to change. No
    existing file is overwritten. Needs no network and no running robot.
    """


@command.command("robot")
@_place
def robot(name: str, into: Path) -> int:
    """Write a robot on two driven wheels.

    It consists of rows: devices, capabilities, channels, and a word of its own.
    """
    return _write("robot", name, into)


@command.command("driver")
@_place
def driver(name: str, into: Path) -> int:
    """Write a driver of a serial device.

    It includes the emulated device, and a test by the checks that every driver has to pass.
    """
    return _write("driver", name, into)


@command.command("servos")
@_place
def servos(name: str, into: Path) -> int:
    """Write a driver of servos on a bus.

    It includes the emulated bus, a robot of two joints, and a test by the checks that every driver of servos has to
    pass.
    """
    return _write("servos", name, into)


@command.command("wheels")
@_place
@click.option("--silent", is_flag=True, help="The controller never answers.")
def wheels(name: str, into: Path, silent: bool) -> int:
    """Write a driver of wheels on a controller.

    It includes the emulated controller, a robot of two wheels, and a test by the checks that every driver of wheels has
    to pass.
    """
    return _write("silent_wheels" if silent else "wheels", name, into)


@command.command("capability")
@_place
def capability(name: str, into: Path) -> int:
    """Write a capability with an input, an output and a command.

    It reads the range sensors, publishes the nearest distance, and has a word on the console.
    """
    return _write("capability", name, into)


def _write(what: What, name: str, into: Path) -> int:
    folder = scaffold.write(what, name, into)
    click.echo(f"wrote {folder}. What to do next:")
    for line in scaffold.next_steps(what, name, folder):
        click.echo(f"  {line}")
    return 0
