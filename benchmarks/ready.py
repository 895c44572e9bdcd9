"""Asks each robot for its first motion as soon as it reports ready, repeatedly, idle and beside busy loops.

`python -m benchmarks ready --n 20 --loops 2`. A refused first command breaks the figure, and so does a robot that is
ready while one of its movers is not.
"""

import argparse
import contextlib
import sys
from collections.abc import Iterator

from benchmarks import Measured
from tests.scenarios.first_command import FIRST, asked_at_ready
from tests.support import programs
from tests.support.figures import Promise, Results

SMOKE = "--n 1 --loops 0 --robots uxa90"
PROMISES = {
    name: Promise(what=f"first commands of {name} that were obeyed, from the ready line to the answer")
    for name in FIRST
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number, the load, and the robots."""
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
                with asked_at_ready(name, ask) as (_, why, took_ms):
                    results.check(name, [why] if why else [])
                results.sample(name, took_ms)
                refused += bool(why)
                print(f"{name} {number + 1}: {why or 'obeyed'} ({took_ms:.0f} ms)", file=sys.stderr, flush=True)
            text.append(f"{name}: {given.n - refused} of {given.n} obeyed beside {given.loops} busy loops")
    return Measured(results=results.ordered(), load=f"{given.loops} busy loops", text="\n".join(text))


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
