"""Somebody steps in the robot's way: S20, and S15 for each sensor. Faster than real time, and the same at each run.

`python -m benchmarks approach --trials 200 --seed 1`; `--json FILE` keeps the figures. Exit code 1 on a contact.

S20: the base moves at 0.5 m/s, forwards or backwards, when a person (a box 0.3 to 0.5 m wide) appears 0.5 m from its
outline. The place is ahead or behind on a straight way, and on the inner side of an arc. Each trial would end in a
collision without braking: others do not count. The sensors' noise grows with the distance, and one reading in a hundred
is missing. Spinning on the spot, a base of this shape only sweeps 11 cm beyond its sides.
"""

import argparse
from statistics import median_high

from benchmarks import Measured
from lbr.operations.drive.settings import DriveSettings
from tests.models.approach import PROMISES, approach, failing, thin
from tests.support.figures import Results

SMOKE = "--trials 1 --faults 1"


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--trials", type=int, default=200, help="from each side (default %(default)s)")
    parser.add_argument(
        "--faults", type=int, default=20, help="tries of each fault of each sensor (default %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Step in its way, and let its sensors fail."""
    drive, results = DriveSettings(), Results(PROMISES)
    outcomes = approach(results, given.trials, given.seed, drive)
    failing(results, given.faults, given.seed, drive)
    count = max(1, given.trials // 4)
    posts = thin(count, given.seed, drive)
    text = []
    for side, found in outcomes.items():
        touched = sum(outcome.contact for outcome in found)
        ways = [outcome.way_m for outcome in found]
        text.append(
            f"{side}: {touched} of {len(found)} touched; {median_high(ways):.2f} m to standing still, {max(ways):.2f} m at most"
        )
    for side, touched in posts.items():
        text.append(f"{side}, posts 5 cm thick: {touched} of {count} touched; beside the cone they are not seen")
    return Measured(results=results.ordered(), load="lockstep, faster than real time", text="\n".join(text))
