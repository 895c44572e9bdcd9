"""Measures how well turns end: by angle and to headings, in simulation, beside the open loop that they replace.

`python -m benchmarks turning --n 200 --json FILE`; nothing sleeps, the same seed gives the same figures. Exit
code 1 if a turn failed, took a revolution too many or longer than it may.
"""

import argparse

from benchmarks import Measured
from tests.models.turning import measure as turns

SMOKE = "--n 2"


def options(parser: argparse.ArgumentParser) -> None:
    """Add how much."""
    parser.add_argument("--n", type=int, default=200, help="turns and headings together (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Turn, beside the open loop."""
    return Measured(results=turns(given.n, given.seed).ordered())
