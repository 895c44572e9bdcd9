"""`lbr record`."""

import signal
import time

import click
import msgspec
from msgspec import Struct

from lbr.apps.recorder.messages import BoxReply, EndRecording, RecordCommand
from lbr.bus import keys, latest, wire
from lbr.bus.session import Session
from lbr.commands.options import Number, Whom, json_option, print_json, robot_options
from lbr.commands.status import ask as status_of
from lbr.console import target
from lbr.console.interrupt import told_to_leave
from lbr.console.target import Target
from lbr.errors import BusError, InputError
from lbr.messages.units import FILE_STEM

ASK_S = 10.0
GONE_S = 20.0
"""The wait for an answer: the box runs only when all others leave it time."""
LOOK_S = 0.5


@click.command("record")
@robot_options
@click.option("--seconds", type=Number(0.1, 86400.0), help="For how long; until Ctrl-C if left out.")
@click.option("--with", "also", multiple=True, type=click.Choice(["cameras"]), help="Every picture, too.")
@click.option("--lines", is_flag=True, help="The bytes of the devices' lines, and commands, too: for `replay --check`.")
@click.option("--name", default="", metavar="NAME", help="The file's; made of the time if left out.")
@json_option
def command(*, whom: Whom, seconds: float | None, also: tuple[str, ...], lines: bool, name: str, as_json: bool) -> int:
    """Record on purpose, into a file of its own below the robot's home: all streams, events and lines of logs.

    Ctrl-C, SIGTERM and a terminal that is closed end it. The black box writes it, so it goes on after a SIGKILL;
    `/record/end` ends it then.
    """
    endpoint, interrupts = target.find(*whom), list[bool]()
    target.need(endpoint, "operate")
    box = _box_of(endpoint)
    with target.connected(endpoint) as bus:
        try:
            asked = msgspec.convert(
                {"seconds": seconds or 0.0, "cameras": "cameras" in also, "lines": lines, "name": name}, RecordCommand
            )
        except msgspec.ValidationError:
            raise InputError(f"--name: {name[:80]!r} cannot be a file's name here: {FILE_STEM}") from None
        with told_to_leave(lambda: interrupts.append(True), signal.SIGINT):
            begun = _ask(bus, endpoint, f"{box}/record", asked)
            try:
                if not as_json:
                    click.echo(begun.reason, err=True)
                if not begun.accepted:
                    return 1
                _wait(bus, endpoint, box, seconds, interrupts)
            finally:
                if begun.accepted:
                    ended = _ask(bus, endpoint, f"{box}/end", EndRecording())
    if as_json:
        print_json({"path": begun.path, "text": ended.reason if ended.accepted else begun.reason})
    else:
        click.echo(ended.reason if ended.accepted else begun.path)
    return 0


def _wait(bus: Session, endpoint: Target, box: str, seconds: float | None, interrupts: list[bool]) -> None:
    """Wait for the end of the recording or an interrupt; raise BusError if the box no longer answers."""
    end = time.monotonic() + seconds + 2.0 if seconds else float("inf")
    answered_at = time.monotonic()
    while time.monotonic() < end and not interrupts:
        time.sleep(LOOK_S)
        states = latest.ask(bus, [keys.port(endpoint.robot, box, "state")], source="lbr record", timeout_s=2.0)
        state = states.get(f"{box}/state")
        if state is not None:
            answered_at = time.monotonic()
            if not state.message.get("recording"):
                return
        elif time.monotonic() - answered_at > GONE_S:
            raise BusError("the black box does not answer any more")


def _box_of(endpoint: Target) -> str:
    status = status_of(endpoint, "lbr record")
    name = next((one.name for one in status.capabilities if one.kind == "box"), "")
    if not name:
        raise BusError(f"'{endpoint.robot}' has no black box that runs: switch on the row 'box'")
    return name


def _ask(bus: Session, endpoint: Target, command: str, message: Struct) -> BoxReply:
    key = f"{endpoint.robot}/{command}"
    answers = wire.ask(bus, key, message, source=target.source("lbr record"), timeout_s=ASK_S)
    if not answers:
        raise BusError(f"{key} does not answer")
    return msgspec.json.decode(answers[0].payload, type=BoxReply)
