"""Sends random input to every interface of a robot: console, bus, sockets, device lines, and walks through all of them.

`python -m benchmarks fuzz --n 1000 --json FILE`; `--only Z1,Z5` runs a few, `--seed` makes the same inputs again. `--n
100000` sends 100,000 lines, 200,000 messages, 10,000 connections, 50 MB and 500 walks of 30 steps. Exit code 1 if
anything crashed, was wrongly accepted, or moved.
"""

import argparse
import random
from collections.abc import Callable
from functools import partial

from benchmarks import Measured, listed, one_by_one
from tests.fuzzing import bus, console, serial, walk
from tests.fuzzing.promises import PROMISES
from tests.support.figures import Result, Results

SMOKE = "--n 20 --only Z1"

KEPT = 1000

Scenario = Callable[[Results, int, random.Random], None]
SCENARIOS: dict[str, tuple[Scenario, float]] = {
    "Z1": (console.consoles, 1.0),
    "Z4": (bus.messages, 2.0),
    "Z5": (serial.lines, 0.0005),
    "Z7": (walk.walks, 0.005),
}
"""Each with its share of `--n`: lines, messages, MB, walks."""


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount, and the scenarios."""
    parser.add_argument("--n", type=int, default=1000, help="how much, more or less (default %(default)s)")
    parser.add_argument("--only", type=listed, default=list(SCENARIOS), metavar="Z1,Z5")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Send random input, one interface after the other."""
    results = Results(PROMISES)
    one_by_one(
        results,
        (
            (
                name,
                name,
                partial(scenario, results, max(1, round(given.n * share)), random.Random(f"{name} {given.seed}")),
            )
            for name, (scenario, share) in SCENARIOS.items()
            if name in given.only
        ),
    )
    return Measured(results=[thinned(result) for result in results.ordered()], load=f"seed {given.seed}")


def thinned(result: Result) -> Result:
    """Return an equivalent result with at most a thousand samples; it still counts them all."""
    result.checks = result.n
    samples = sorted(result.samples)
    step = max(1, len(samples) // KEPT)
    result.samples = samples[::-1][::step]
    result.violations = result.violations[:50]
    return result
