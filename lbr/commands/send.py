"""`lbr send`."""

import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed

import click

from lbr import home
from lbr.commands.completing import complete_line
from lbr.commands.options import Number, Whom, json_option, print_json, robot_options
from lbr.commands.speaking import speaking
from lbr.console import lines, printable, stops, target
from lbr.console.target import Target
from lbr.errors import InputError, LbrError
from lbr.messages.plain import one_line
from lbr.messages.system import ConsoleResult

LOOK_S = 0.05


@click.command("send", context_settings={"ignore_unknown_options": True})
@click.argument("words", nargs=-1, required=True, type=click.UNPROCESSED, metavar="LINE", shell_complete=complete_line)
@robot_options
@click.option(
    "--hold",
    "hold_s",
    type=Number(0.0, 30.0),
    default=5.0,
    show_default=True,
    metavar="SECONDS",
    help="How long to hold a motion that has no bounds of its own.",
)
@click.option(
    "--wait",
    "wait_s",
    type=Number(0.0, 600.0),
    default=10.0,
    show_default=True,
    metavar="SECONDS",
    help="How long to wait for a robot whose start is under way here.",
)
@json_option
def command(words: tuple[str, ...], whom: Whom, hold_s: float, wait_s: float, as_json: bool) -> int:
    """Send one console LINE, such as /r/0.2/0 or stop.

    A motion without bounds is held for --hold seconds and then stopped; a bounded one lasts until its result. Ctrl-C
    stops it. stop and estop go to every robot that runs here, unless one is named. Exit code 0: done, 1: refused or
    failed, 2: bad input.
    """
    line = printable.clean(" ".join(words))
    if not line:
        raise InputError("there is nothing to send; 'lbr send help' lists all words")
    if line.startswith("!"):
        raise InputError("Python runs at the robot's own console only; 'lbr send help' lists all words")

    def announce(result: ConsoleResult) -> None:
        if not as_json:
            lines.show(result, sys.stdout, sys.stderr)

    if not whom.connect:
        await_start(whom.robot, wait_s)
    found, *others = target.find_to_stop(*whom) if stops.is_stop(line) else [target.find(*whom)]
    if others:
        return _stop_all([found, *others], line, as_json)
    with speaking(found, "lbr send") as said:
        result, code, ending = lines.say_once(said, line, hold_s=hold_s, announce=announce)
    if as_json:
        print_json(
            {
                "code": code,
                "text": result.text,
                "reason_code": result.reason_code,
                "cause": result.cause,
                "data": result.data,
                "ending": ending.text if ending else "",
                "ending_code": ending.code if ending else "",
            }
        )
    elif ending:
        click.echo(one_line(ending.text), err=code != 0)
    return code


def await_start(robot: str | None, wait_s: float) -> None:
    """Wait for a robot whose start is under way, and report that; return at once if it is not starting."""
    until, reported = time.monotonic() + wait_s, False
    while not any(robot in {None, one.robot} for one in home.running()):
        names = [name or "a robot" for name in home.starting() if not name or robot in {None, name}]
        if not names or time.monotonic() >= until:
            return
        if not reported:
            click.echo(f"{', '.join(names)} is starting: waiting for it, {wait_s:g} s at most", err=True)
            reported = True
        time.sleep(LOOK_S)


def _stop_all(robots: list[Target], line: str, as_json: bool) -> int:
    """Send a stop to each robot, and print the answers as they come; no robot waits for another."""
    results: dict[str, ConsoleResult] = {}
    with ThreadPoolExecutor(len(robots)) as pool:
        asked = {pool.submit(_result, robot, line): robot.robot for robot in robots}
        for answered in as_completed(asked):
            results[asked[answered]] = result = answered.result()
            if not as_json:
                click.echo(f"{asked[answered]}: {one_line(result.text)}", err=result.code != 0)
    if as_json:
        print_json({name: {"code": result.code, "text": result.text} for name, result in results.items()})
    return max(result.code for result in results.values())


def _result(robot: Target, line: str) -> ConsoleResult:
    try:
        with speaking(robot, "lbr send") as said:
            return said.submit(line)
    except LbrError as err:
        return ConsoleResult(code=1, text=str(err))
