"""Counts the figures of the drive kernel in full.

`python -m benchmarks motion --only F2,F3 --share 0.1`; exit code 1 if anything was violated.
"""

import argparse
import time

from hypothesis import HealthCheck, settings
from hypothesis.stateful import run_state_machine_as_test

from benchmarks import Measured, listed
from tests.models.motion.counted import FIGURES, Count
from tests.models.motion.machine import MotionMachine
from tests.support.figures import Promise, Results

SMOKE = "--share 0.001"
PROMISES = {
    f"{name} kernel": Promise(what=what)
    for name, what in (
        ("F1", "what a link that was cut for 0.3 to 8 s delivers when it heals moves nothing"),
        ("F2", "whatever was once said is said again, byte for byte: none counts"),
        ("F3", "stamps with impossible numbers: order is what their time says"),
        ("S18", "a move with an end stops at it, whatever is late or missing"),
        ("F5", "histories that chance chooses: the kernel does what its model does"),
    )
}

SEQUENCES, STEPS = 2_000, 40


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--only", type=listed, default=[*FIGURES, "F5"], metavar="F1,F5")
    parser.add_argument("--share", type=float, default=1.0, help="of the full amount (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Count each figure."""
    results, text = Results(PROMISES), []
    for name in given.only:
        began = time.monotonic()
        if name == "F5":
            count = arbitration(max(1, round(SEQUENCES * given.share)))
        else:
            function, amount = FIGURES[name]
            count = function(max(1, round(amount * given.share)), given.seed)
        result = results.of(f"{name} kernel")
        result.checks, result.violations = count.tried, count.problems
        text.append(f"{name}: {count.tried} tried, {len(count.problems)} problems, {time.monotonic() - began:.1f} s")
    return Measured(results=results.ordered(), load="nothing sleeps", text="\n".join(text))


def arbitration(n: int) -> Count:
    """F5: histories that Hypothesis chooses, kernel and model side by side; one that differs is shrunk and printed."""
    budget = settings(
        max_examples=n,
        stateful_step_count=STEPS,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    count = Count(figure="F5", tried=n)
    try:
        run_state_machine_as_test(MotionMachine, settings=budget)
    except AssertionError as err:
        count.problems.append(str(err))
    return count
