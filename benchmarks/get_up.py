"""Measures how often a humanoid that has fallen gets up by the motions of its rows, for each side on which it may lie.

`python -m benchmarks get_up --n 20 --json FILE`; nothing sleeps, the same seed gives the same figures. The kernel of the
joints operation moves the rows' simulated bodies, with noise and with the motors' own limits.
"""

import argparse

from benchmarks import Measured
from tests.models import get_up

SMOKE = "--n 1 --only face"


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--n", type=int, default=20, help="falls on each side (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")
    parser.add_argument("--only", default="", help="falls whose robot and side have this in them")


def measure(given: argparse.Namespace) -> Measured:
    """Let them fall, and get up."""
    results, text = get_up.measure(given.n, given.seed, given.only)
    return Measured(results=results.ordered(), text=text)
