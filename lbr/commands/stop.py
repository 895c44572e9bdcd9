"""`lbr stop`."""

import contextlib
import os
import signal
import time

import click

from lbr import home
from lbr.commands.options import Whom, robot_options
from lbr.commands.speaking import speaking
from lbr.console import target
from lbr.errors import BusError

GONE_S = 15.0
POLL_S = 0.05


@click.command("stop")
@robot_options
def command(whom: Whom) -> int:
    """Shut a robot down in order, and wait until it is gone. (To stop only the motion, use 'lbr send stop'.)"""
    robot = target.find(*whom)
    if robot.running is not None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(robot.running.pid, signal.SIGTERM)
            os.kill(robot.running.pid, signal.SIGCONT)  # a frozen process would not receive the signal
        until = time.monotonic() + GONE_S
        while any(one.pid == robot.running.pid for one in home.running()):
            if not time.monotonic() < until:
                raise BusError(f"robot '{robot.robot}' (pid {robot.running.pid}) is not gone after {GONE_S:g} s")
            time.sleep(POLL_S)
        click.echo(f"robot '{robot.robot}' has shut down")
        return 0
    with speaking(robot, "lbr stop") as speaker:
        result = speaker.submit("Shutdown")
    click.echo(result.text, err=result.code != 0)
    return result.code
