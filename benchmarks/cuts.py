"""Measures the losses by a power cut: acknowledged rows, the emergency stop's latch, and the black box's recordings.

`python -m benchmarks cuts --n 50`, as root. The robot's home is a file system of its own. At a random moment it drops
unsynced data and stops writing; then it is mounted again, and read. A disk that acknowledges writes falsely is not
tested.
"""

import argparse
import random
import sys

from benchmarks import Measured
from lbr.errors import InputError
from tests.scenarios.cuts import cut
from tests.support import cut_disk
from tests.support.figures import Promise, Results

SMOKE = "--n 1 --seconds 3"
PROMISES = {
    "PC1": Promise(what="power cuts: acknowledged edits and latch are there, database whole and `lbr db check` clean"),
    "PC2": Promise(what="messages older than 1 s that are gone after a power cut, of all of them", unit="%", hard=1.0),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number."""
    parser.add_argument("--n", type=int, default=20, help="cuts (default %(default)s)")
    parser.add_argument("--seconds", type=float, default=8.0, help="at most until a cut (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Cut the power, and check."""
    if not cut_disk.possible():
        raise InputError(f"a disk whose power can be cut needs {cut_disk.NEEDS}", "not_possible")
    results, dice, edits, older, gone = Results(PROMISES), random.Random(given.seed), 0, 0, 0
    for number in range(given.n):
        one = cut(results, dice.uniform(min(2.5, given.seconds), given.seconds), dice)
        results.check("PC1", one.wrong)
        edits, older, gone = edits + one.edits, older + one.older, gone + one.gone
        rows = "; ".join(one.wrong) or "rows whole"
        print(f"cut {number + 1}: {one.gone} of {one.older} gone; {rows}", file=sys.stderr, flush=True)
    results.sample("PC2", 100 * gone / max(1, older))
    text = f"{given.n} cuts: {older} messages were older than 1 s, {gone} of them are gone; {edits} edits were acknowledged"
    return Measured(results=results.ordered(), text=text)
