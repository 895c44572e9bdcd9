"""Somebody steps in the robot's way: S20, and S15 for each sensor. Faster than real time, and the same at each run.

`python -m benchmarks.approach --trials 200 --seed 1`; `--json FILE` keeps the figures. Exit code 1 on a contact.

S20: the base moves at 0.5 m/s when somebody (a box 0.3 to 0.5 m wide) appears 0.5 m from its outline: ahead or behind
while it drives straight, to its left or right while it drives an arc to that side, forwards or backwards. Each trial
is one that ends in a collision if nobody brakes: what would have passed by itself does not count. The sensors' noise
grows with the distance, and one reading in a hundred is missing.

Spinning on the spot, a base of this shape sweeps 11 cm beyond its sides: nothing 0.5 m away is in its way.
"""

import argparse
import sys
import time
from pathlib import Path

from lbr.operations.drive.settings import DriveSettings
from tests.models.approach import PROMISES, approach, failing, thin
from tests.support.figures import Report, Results, machine, table


def main() -> int:
    """Measure, print, keep, and say whether anything was touched."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=200, help="from each side (default %(default)s)")
    parser.add_argument(
        "--faults", type=int, default=20, help="tries of each fault of each sensor (default %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="the same seed gives the same run (default %(default)s)")
    parser.add_argument("--json", type=Path, help="also write the figures to this file")
    arguments = parser.parse_args()
    drive, results = DriveSettings(), Results(PROMISES)
    started, began = time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime()), time.monotonic()
    outcomes = approach(results, arguments.trials, arguments.seed, drive)
    failing(results, arguments.faults, arguments.seed, drive)
    posts = thin(arguments.trials // 4, arguments.seed, drive)
    report = Report(
        machine=machine(),
        load="lockstep, faster than real time",
        started=started,
        took_s=round(time.monotonic() - began, 1),
        results=results.ordered(),
    )
    if arguments.json:
        report.write(arguments.json)
    print(table(report.results))
    print()
    for side, found in outcomes.items():
        touched = sum(outcome.contact for outcome in found)
        ways = [outcome.way_m for outcome in found]
        print(
            f"{side}: {touched} of {len(found)} touched; {_median(ways):.2f} m to standing still, {max(ways):.2f} m at most"
        )
    for side, touched in posts.items():
        print(
            f"{side}, posts 5 cm thick: {touched} of {arguments.trials // 4} touched; beside the cone they are not seen"
        )
    return report.tell_broken()


def _median(values: list[float]) -> float:
    return sorted(values)[len(values) // 2]


if __name__ == "__main__":
    sys.exit(main())
