"""Asks a simulated UXA-90 whatever its OpenAPI document allows, and more, and looks at answers and at the wire.

`python -m benchmarks.rest_cases --cases 1000 [--json FILE] [--seed N]`. Exit code 1 if an answer was a 5xx, did not come
within five seconds, was not what the document says, or if anything illegal was on the serial line.
"""

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

from tests.fuzzing.rest_cases import ask_all, on_the_wire, served


def main() -> int:
    """Ask, print, and say whether anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="lbr-") as place, served(Path(place) / "h") as (_, client, trace):
        began = time.monotonic()
        tally = ask_all(client, arguments.cases, arguments.seed)
        took_s = time.monotonic() - began
        wire, illegal = on_the_wire(trace)
    found = {
        "cases": sum(tally.statuses.values()),
        "statuses": {str(status): count for status, count in sorted(tally.statuses.items())},
        "operations": len(tally.operations),
        "seconds": round(took_s, 1),
        "slowest_ms": round(tally.slowest_s * 1e3, 1),
        "wrong": tally.wrong,
        "wire": dict(wire),
        "illegal": illegal[:20],
    }
    print(json.dumps(found, indent=2))
    if arguments.json:
        arguments.json.write_text(json.dumps(found, indent=2) + "\n")
    return int(bool(tally.wrong or illegal))


if __name__ == "__main__":
    sys.exit(main())
