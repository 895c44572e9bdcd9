"""Measures whether a humanoid that is stopped in mid-step stays on its feet, at random moments of each walk and
stand-up.

`python -m benchmarks feet --n 50 --json FILE`; nothing sleeps, the same seed gives the same figures. The kernel of the
joints operation moves the rows' simulated bodies, with noise. Beside each count: the same moments, held at once.
"""

import argparse

from benchmarks import Measured
from tests.models import feet

SMOKE = "--n 1 --only walk_ahead --alone"


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--n", type=int, default=50, help="stops of each motion (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")
    parser.add_argument("--only", default="", help="motions whose robot and name have this in them")
    parser.add_argument("--alone", action="store_true", help="do not hold at once beside it")
    parser.add_argument("--lapse", action="store_true", help="the sender falls silent, instead of a stop")


def measure(given: argparse.Namespace) -> Measured:
    """Stop the humanoids."""
    results, text = feet.measure(given.n, given.seed, given.only, beside=not given.alone, lapse=given.lapse)
    return Measured(results=results.ordered(), text=text)
