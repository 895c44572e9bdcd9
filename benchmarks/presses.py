"""Presses the emergency stop of each robot, at rest and in mid-motion: is it acknowledged, and after how long?

`python -m benchmarks presses --n 20`. An answer that raises an alarm breaks the figure: the robots are healthy.
"""

import argparse
import sys
import tempfile
import threading
import time
from pathlib import Path

from benchmarks import Measured
from lbr.testing.robot import NoAnswerError
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import until

SMOKE = "--n 1 --robots lbr"
MOTIONS = {"lbr": ("", "/r/0.4/0"), "bioloid": ("/torque/on", "/play/wave"), "uxa90": ("", "/play/walk_forward_6step")}
"""The first line for each robot, and the line of its motion."""
PROMISES = {
    f"{name} {how}": Promise(what=f"emergency stop of {name} pressed {how}, to its acknowledgement")
    for name in MOTIONS
    for how in ("at rest", "in motion")
}
MOVES_S = 1.0
START_S = 60.0


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number, and the robots."""
    parser.add_argument("--n", type=int, default=20, help="presses of each, both ways (default %(default)s)")
    parser.add_argument("--robots", default=",".join(MOTIONS), help="which (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Press, reset, and repeat."""
    results = Results(PROMISES)
    for name in given.robots.split(","):
        with tempfile.TemporaryDirectory(prefix="lbr-presses-") as place:
            home = prepare(Path(place) / "home", whole=True)
            with running(home, profile=f"{name}-sim", limit_s=START_S) as robot:
                for number in range(given.n):
                    for how in ("at rest", "in motion"):
                        press(robot, results, f"{name} {how}", number)
    return Measured(results=results.ordered())


def press(robot: Robot, results: Results, figure: str, number: int) -> None:
    """Press once, and release it."""
    first, motion = MOTIONS[robot.name]
    thread = None
    if figure.endswith("in motion"):
        if first:
            until(lambda: robot.line(first)["code"] == 0, limit_s=10.0, what=first)
        thread = threading.Thread(target=keep, args=(robot, motion))
        thread.start()
        time.sleep(MOVES_S)
    began = time.monotonic()
    answer = robot.line("estop")
    took_ms = (time.monotonic() - began) * 1e3
    results.check(figure, [answer["text"]] if answer["code"] else [])
    results.sample(figure, took_ms)
    print(f"{figure} {number + 1}: {answer['text']} ({took_ms:.0f} ms)", file=sys.stderr, flush=True)
    until(lambda: robot.line("reset")["code"] == 0, limit_s=10.0, what="released")
    if thread is not None:
        thread.join()


def keep(robot: Robot, motion: str) -> None:
    """Continue a motion until something ends it; after a reset, the base is armed in a moment."""
    try:
        until(lambda: robot.line(motion)["hold"], limit_s=10.0, what=motion)
        ended = robot.move(motion, 60.0)
    except (NoAnswerError, AssertionError) as err:
        print(f"{motion}: {err}", file=sys.stderr)
        return
    if ended.get("cause") != "estop":
        print(f"{motion} ended by itself: {ended}", file=sys.stderr)
