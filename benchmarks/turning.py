"""Measures the precision of turns by angle and to headings, in simulation, compared with the open loop that they
replace.

`python -m benchmarks turning --n 200 --json FILE`; nothing sleeps, the same seed gives the same figures. Exit code 1 if
a turn failed, made a revolution too many or took too long.
"""

import argparse

from benchmarks import Measured
from tests.models.turning import measure as turns

SMOKE = "--n 2"


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--n", type=int, default=200, help="turns and headings together (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Turn, and compare with the open loop."""
    return Measured(results=turns(given.n, given.seed).ordered())
