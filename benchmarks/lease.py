"""Searches every world of the model to its last state, then finds every seeded error.

`python -m benchmarks.lease`, or `--worlds ,t,c`; exit code 1 if a property breaks, an error is not found, or no end is.
Each letter of a world adds to two clients on the robot: t(ake-over), e(mergency stop),
c(rashes), r(emote: the second client is on another machine), i(nsisting is noticed; without it e breaks property 7).
"""

import argparse
import sys
import tempfile
from pathlib import Path

from tests.models.lease.seeded import PROPERTIES, SEEDED
from tests.models.lease.spin import DEEP, FINE_S, Search

WORLDS = ("", "t", "i", "c", "r", "ei")
HASH_BITS = 25


def main() -> int:
    """Search, print what came out, and say whether all is as it should be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", default=",".join(WORLDS), metavar=",t,c", help="default: %(default)s")
    worlds = parser.parse_args().worlds.split(",")
    bad = False
    with tempfile.TemporaryDirectory(prefix="lbr-lease-") as folder:
        search = Search(Path(folder), FINE_S)
        for world in worlds:
            found = search.run(world, depth=DEEP, hash_bits=HASH_BITS)
            bad = bad or not found.closed or found.broken > 0
            said = "closed, nothing breaks" if found.closed else PROPERTIES.get(found.broken, "NOT SEARCHED TO ITS END")
            figures = (
                f"{found.states:>10,} states, depth {found.depth:,}, {found.seconds:.0f} s, {found.megabytes:.0f} MB"
            )
            print(f"{world or '-':4} {figures}: {said}", flush=True)
            for line in found.trace[-30:]:
                print(f"       {line}")
        for seeded in SEEDED:
            found = search.run(seeded.world, seeded.number)
            right = found.broken == seeded.breaks
            bad = bad or not right
            print(f"{seeded.name}: {'found' if right else 'NOT FOUND'}, breaks {found.broken}, {found.states:,} states")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
