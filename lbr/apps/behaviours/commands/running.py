"""Commands of `lbr behaviour` that a running robot carries out."""

import time

import click
import msgspec

from lbr.bus import keys, wire
from lbr.bus.codec import Decoder
from lbr.commands import send
from lbr.commands.options import Whom, print_json
from lbr.console import target
from lbr.errors import BusError
from lbr.messages.behaviour import BehaviourState

LOOK_S = 0.2
_state = Decoder(BehaviourState)


def send_line(context: click.Context, line: str, whom: Whom, *, as_json: bool) -> object:
    """Send one console line, print its answer, and return the exit code."""
    return context.invoke(
        send.command,
        words=(line,),
        robot=whom.robot,
        connect=whom.connect,
        token_file=whom.token_file,
        hold_s=5.0,
        as_json=as_json,
    )


def wait_for_end(whom: Whom, *, as_json: bool) -> int:
    """Wait for the end of the run, print the states on the way, and return 0 if it ended well, else 1."""
    robot, last = target.find(*whom), ""
    key, source = keys.port(robot.robot, "behaviour", "state"), target.source("lbr behaviour")
    with target.connected(robot) as bus:
        while True:
            answers = wire.ask(bus, key, None, source=source)
            if not answers:
                raise BusError(f"robot '{robot.robot}' does not report its run on {key}")
            state = _state.decode(answers[0].payload)
            if state.phase in {"ended", "resting"}:
                break
            if state.state != last and not as_json:
                last = state.state
                click.echo(f"{last} ...")
            time.sleep(LOOK_S)
    if as_json:
        print_json(msgspec.to_builtins(state))
    else:
        click.echo(f"{state.state}: {state.reason}", err=not state.good)
    return 0 if state.good else 1
