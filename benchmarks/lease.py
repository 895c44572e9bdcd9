"""Searches every world of the model to its last state, then finds every seeded error.

`python -m benchmarks lease`, or `--worlds ,t,c`; exit code 1 if a property breaks, an error is not found, or a search
does not end. Each letter of a world adds a feature to two clients on the robot. t: take-over. e: emergency stop. c:
crashes. r: the second client is on another machine. i: insisting is noticed; without it, e breaks property 7.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from benchmarks import Measured
from tests.models.lease.seeded import PROPERTIES, SEEDED
from tests.models.lease.spin import DEEP, FINE_S, Search
from tests.support.figures import Promise, Results

SMOKE = "--worlds none --errors 1"
PROMISES = {
    "lease": Promise(what="worlds of the model, searched to their last state, in which no property breaks"),
    "lease errors": Promise(what="errors seeded in the model that the search finds"),
}

WORLDS = ("", "t", "i", "c", "r", "ei")
HASH_BITS = 25


def options(parser: argparse.ArgumentParser) -> None:
    """Add the worlds."""
    parser.add_argument("--errors", type=int, default=len(SEEDED), help="seeded errors to find (default: all)")
    parser.add_argument(
        "--worlds",
        default=",".join(WORLDS),
        metavar=",t,c",
        help="or none: the seeded errors alone (default: %(default)s)",
    )


def measure(given: argparse.Namespace) -> Measured:
    """Search the worlds, then the seeded errors."""
    results, text = Results(PROMISES), []
    with tempfile.TemporaryDirectory(prefix="lbr-lease-") as folder:
        search = Search(Path(folder), FINE_S)
        for world in [] if given.worlds == "none" else given.worlds.split(","):
            found = search.run(world, depth=DEEP, hash_bits=HASH_BITS)
            said = "closed, nothing breaks" if found.closed else PROPERTIES.get(found.broken, "NOT SEARCHED TO ITS END")
            results.check("lease", [f"world {world or '-'}: {said}"] if found.broken or not found.closed else [])
            states = (
                f"{found.states:>10,} states, depth {found.depth:,}, {found.seconds:.0f} s, {found.megabytes:.0f} MB"
            )
            text += [f"{world or '-':4} {states}: {said}", *(f"       {line}" for line in found.trace[-30:])]
            print(text[-1], file=sys.stderr, flush=True)
        for seeded in SEEDED[: given.errors]:
            found = search.run(seeded.world, seeded.number)
            right = found.broken == seeded.breaks
            results.check("lease errors", [] if right else [f"{seeded.name} was not found"])
            text.append(
                f"{seeded.name}: {'found' if right else 'NOT FOUND'}, breaks {found.broken}, {found.states:,} states"
            )
    return Measured(results=results.ordered(), load="spin", text="\n".join(text))
