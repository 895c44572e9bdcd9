"""`lbr stop`."""

import contextlib
import os
import signal
import time

import click

from lbr import home
from lbr.commands.options import Whom, robot_options
from lbr.console import operator, target
from lbr.errors import BusError

GONE_S = 15.0
POLL_S = 0.05


@click.command("stop")
@robot_options
def command(whom: Whom) -> int:
    """Shut a robot down in order, and wait until it is gone. (To stop driving only, say 'lbr send stop'.)"""
    found = target.find(*whom)
    if found.running is not None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(found.running.pid, signal.SIGTERM)
            os.kill(found.running.pid, signal.SIGCONT)  # what is frozen would never hear it
        until = time.monotonic() + GONE_S
        while any(one.pid == found.running.pid for one in home.running()):
            if not time.monotonic() < until:
                raise BusError(f"robot '{found.robot}' (pid {found.running.pid}) is not gone after {GONE_S:g} s")
            time.sleep(POLL_S)
        click.echo(f"robot '{found.robot}' has shut down")
        return 0
    with target.connected(found) as bus:
        said = operator.BusOperator(
            bus, found.robot, target.source("lbr stop"), role=found.role, proof=found.proof, listen=False
        )
        result = said.submit("Shutdown")
    click.echo(result.text, err=result.code != 0)
    return result.code
