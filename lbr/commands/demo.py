"""`lbr demo`: a simulated robot shows what it can do, by commands that are printed as they would be typed."""

import json
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import click

from lbr.capability.die_with_parent import dying_with_parent
from lbr.commands.options import DEFAULT_PROFILE, complete_profile
from lbr.errors import InputError, LbrError
from lbr.executive.planning import profile as profiles

LBR = (sys.executable, "-P", "-m", "lbr.start")


@click.command("demo")
@click.argument("profile", default=DEFAULT_PROFILE, shell_complete=complete_profile)
def command(profile: str) -> int:
    """Start a simulated robot, have it show what it can do, and shut it down: a tour of a minute or two.

    The launch profile PROFILE (default lbr-sim) lists the commands of the tour. Each is printed before it runs, and its
    result after it. Ctrl-C ends the tour and the robot. Exit code 1: a command failed.
    """
    tour = profiles.load(profile)
    if not tour.simulate:
        raise InputError(
            f"launch profile '{profile}' moves a real robot: a tour takes a simulated one, such as lbr-sim"
        )
    if not tour.demo:
        raise InputError(f"launch profile '{profile}' has no tour: add a line such as demo = [\"send /t/90\"]")
    with _running(profile):
        return max([_typed(line, tour.robot) for line in tour.demo])


def _typed(line: str, robot: str) -> int:
    """Print a command of `lbr`, run it, and return its exit code, at most 1."""
    click.echo(f"$ lbr {line}")
    return min(1, subprocess.run([*LBR, *shlex.split(line), "--robot", robot], check=False).returncode)


@contextmanager
def _running(profile: str) -> Iterator[None]:
    """Run a robot from when it is ready, for the time of a `with`; it ends with this process, however that ends."""
    click.echo(f"$ lbr run {profile}")
    argv = dying_with_parent((*LBR, "run", profile, "--no-console"))
    with subprocess.Popen(argv, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as robot:
        assert robot.stdout is not None
        try:
            if not (line := robot.stdout.readline()):
                raise click.exceptions.Exit(robot.wait())  # it has printed why
            start = json.loads(line)
            if not start["ready"]:
                reasons = "; ".join(f"{name}: {reason}" for name, reason in start["failed"].items())
                raise LbrError(f"launch profile '{profile}' is not ready: {reasons}")
            yield
        finally:
            robot.terminate()
