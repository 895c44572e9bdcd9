"""Asks each robot for its first motion at the very line that says it is ready, start after start, idle and beside busy loops.

`python -m benchmarks ready --n 20 --loops 2`. A first command that is refused breaks the figure, and so does a robot that
is called ready while something that moves is not.
"""

import argparse
import contextlib
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks import Measured
from tests.support import programs
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, prepare, running

SMOKE = "--n 1 --loops 0 --robots uxa90"
PROMISES = {
    name: Promise(what=f"first commands of {name} that were obeyed, from the ready line to the answer")
    for name in ("lbr", "bioloid", "uxa90")
}
START_S = 60.0


def line(text: str) -> Callable[[Robot], str]:
    """Return a first command by the console, which returns why it was refused, or nothing."""

    def ask(robot: Robot) -> str:
        answer = robot.line(text)
        return "" if answer["code"] == 0 else f"{text}: {answer.get('reason_code')}: {answer['text']}"

    return ask


def motor(robot: Robot) -> str:
    """Ask the UXA-90's own API for a motion of one servo."""
    try:
        with urllib.request.urlopen(f"{robot.web}/motor?id=23&position=100&torq=4", timeout=5.0):
            return ""
    except urllib.error.HTTPError as err:
        return f"GET /motor: {err.code}: {err.read().decode(errors='replace')}"


FIRST: dict[str, tuple[Callable[[Robot], str], ...]] = {
    "lbr": (line("/r/0.2/0"), line("/t/30")),
    "bioloid": (line("/torque/on"),),
    "uxa90": (motor, line("/play/basic_motion")),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add how often, beside what, and which robots."""
    parser.add_argument("--n", type=int, default=20, help="starts of each robot (default %(default)s)")
    parser.add_argument("--loops", type=int, default=0, help="busy loops beside them (default %(default)s)")
    parser.add_argument("--robots", default="lbr,bioloid,uxa90", help="which (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Start each, and ask at once; the first commands take turns."""
    results, text = Results(PROMISES), []
    with busy(given.loops):
        for name in given.robots.split(","):
            refused = 0
            for number in range(given.n):
                ask = FIRST[name][number % len(FIRST[name])]
                why, took_ms = start(name, ask)
                results.check(name, [why] if why else [])
                results.sample(name, took_ms)
                refused += bool(why)
                print(f"{name} {number + 1}: {why or 'obeyed'} ({took_ms:.0f} ms)", file=sys.stderr, flush=True)
            text.append(f"{name}: {given.n - refused} of {given.n} obeyed beside {given.loops} busy loops")
    return Measured(results=results.ordered(), load=f"{given.loops} busy loops", text="\n".join(text))


def start(name: str, ask: Callable[[Robot], str]) -> tuple[str, float]:
    """Start a robot as it ships and ask it; return why it was refused, or nothing, and after how many milliseconds."""
    with tempfile.TemporaryDirectory(prefix="lbr-ready-") as home:
        prepared = prepare(Path(home) / "home", whole=True)
        with running(prepared, profile=f"{name}-sim", limit_s=START_S) as robot:
            since = time.monotonic()
            lacking = [
                each for each in ("motors", "servos", "drive", "joints", "motions") if each in robot.ready["degraded"]
            ]
            why = f"ready with {robot.ready['degraded']}" if lacking or not robot.ready["ready"] else ask(robot)
            return why, (time.monotonic() - since) * 1e3


@contextlib.contextmanager
def busy(count: int) -> Iterator[None]:
    """Keep processors busy."""
    loops = [programs.start([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
