"""Sends a simulated UXA-90 random requests within its OpenAPI document, and beyond, and checks answers and wire.

`python -m benchmarks rest_cases --cases 1000 [--json FILE] [--seed N]`. Exit code 1 if an answer was a 5xx, came after
more than five seconds, or did not fit the document, or if anything illegal was on the serial line.
"""

import argparse
import tempfile
import time
from pathlib import Path

from benchmarks import Measured
from tests.fuzzing.rest_cases import ANSWER_S, ask_all, on_the_wire, served
from tests.support.figures import Promise, Results

SMOKE = "--cases 20"
PROMISES = {
    "rest": Promise(what="requests of every kind: no 5xx, answers as the document says, nothing illegal on the line"),
    "rest slowest": Promise(what="request to its answer", hard=ANSWER_S * 1e3),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number."""
    parser.add_argument("--cases", type=int, default=1000, help="requests (default %(default)s)")
    parser.add_argument("--seed", type=int, help="of chance, to ask the same again")


def measure(given: argparse.Namespace) -> Measured:
    """Send requests, and check answers and wire."""
    results = Results(PROMISES)
    with tempfile.TemporaryDirectory(prefix="lbr-") as place, served(Path(place) / "h") as (_, client, trace):
        began = time.monotonic()
        tally = ask_all(client, given.cases, given.seed)
        took_s = time.monotonic() - began
        wire, illegal = on_the_wire(trace)
    result = results.of("rest")
    result.checks, result.violations = sum(tally.statuses.values()), [*tally.wrong, *illegal[:20]]
    results.sample("rest slowest", tally.slowest_s * 1e3)
    figures = {
        "statuses": {str(status): count for status, count in sorted(tally.statuses.items())},
        "operations": len(tally.operations),
        "seconds": round(took_s, 1),
        "wire": dict(wire),
    }
    return Measured(results=results.ordered(), figures=figures)
