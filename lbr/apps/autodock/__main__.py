"""The program: `python -m lbr.apps.autodock --help`."""

import argparse
import sys
import time
from collections.abc import Iterator
from typing import cast

from lbr.apps import program
from lbr.apps.autodock.pilot import Pilot
from lbr.apps.autodock.script import Manner, dock
from lbr.apps.autodock.view import Ending, GivenUpError, Say, View
from lbr.apps.program import Robot
from lbr.errors import BusError

PERIOD_S = 0.1
PATIENCE_S = 10.0


def main() -> int:
    """Dock; exit code 0 if the battery is being charged in the end."""
    given = _arguments(sys.argv[1:])
    manner = Manner(side=given.side, docked_back_m=given.back / 100, tries=given.tries)
    with program.connected("autodock") as robot:
        ending = run(robot, manner, given.heading)
    _tell(ending.text)
    return 0 if ending.good else program.FAILED


def run(robot: Robot, manner: Manner, heading_deg: float) -> Ending:
    """Dock; the robot stands in the end, however it ends, and if not by us then because its lease lapses."""
    pilot = Pilot(robot, heading_deg)
    script = dock(manner)
    action = next(script)
    try:
        for view in _views(pilot):
            halted = pilot.stopped and not isinstance(action, Say)
            if not halted:
                pilot.do(action)
            try:
                action = script.throw(GivenUpError(pilot.stopped)) if halted else script.send(view)
            except StopIteration as end:
                return cast("Ending", end.value)
            if isinstance(action, Say):
                _tell(action.text)
    finally:
        pilot.stop()
    raise AssertionError("views never end")


def _views(pilot: Pilot) -> Iterator[View]:
    """Yield ten views a second; a robot that does not know how it lies stands, and is waited for a while."""
    due = seen = time.monotonic()
    while True:
        try:
            view = pilot.look()
        except BusError as err:
            pilot.break_off(str(err))
            if time.monotonic() - seen > PATIENCE_S:
                raise
        else:
            seen = time.monotonic()
            yield view
        due = max(due + PERIOD_S, time.monotonic())
        time.sleep(max(0.0, due - time.monotonic()))


def _tell(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def _arguments(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="autodock", description="Find the charging dock and back onto it.")
    parser.add_argument(
        "--heading", type=float, default=0.0, metavar="DEG", help="compass heading of the docked robot (0)"
    )
    parser.add_argument(
        "--side",
        choices=("left", "right"),
        default="left",
        help="where to look first, as the docked robot looks (left)",
    )
    parser.add_argument(
        "--back", type=float, default=36.0, metavar="CM", help="what the rear sensor reads on the dock (36)"
    )
    parser.add_argument("--tries", type=int, default=5, metavar="N", help="how often to try (5)")
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(program.run(main))
