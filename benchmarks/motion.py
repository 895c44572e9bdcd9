"""Counts the figures of the drive kernel at their full amount.

`python -m benchmarks.motion --only F2,F3 --share 0.1`; exit code 1 if anything was violated.
"""

import argparse
import sys
import time

from hypothesis import HealthCheck, settings
from hypothesis.stateful import run_state_machine_as_test

from tests.models.motion.counted import FIGURES, Count
from tests.models.motion.machine import MotionMachine

SEQUENCES, STEPS = 2_000, 40


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


def main() -> int:
    """Count, print, and say whether anything was violated."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default=",".join([*FIGURES, "F5"]), metavar="F1,F5")
    parser.add_argument("--share", type=float, default=1.0, help="of the full amount (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    bad = False
    for name in arguments.only.split(","):
        began = time.monotonic()
        if name == "F5":
            count = arbitration(max(1, round(SEQUENCES * arguments.share)))
        else:
            function, amount = FIGURES[name]
            count = function(max(1, round(amount * arguments.share)), arguments.seed)
        bad = bad or bool(count.problems)
        print(
            f"{name}: {count.tried} tried, {len(count.problems)} problems, {time.monotonic() - began:.1f} s", flush=True
        )
        for problem in count.problems[:5]:
            print(f"  {problem}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
