"""Throws chance at every way into a robot: console, bus, sockets, device lines, and the whole of its interface.

`python -m benchmarks.fuzz --n 1000 --json FILE`; `--only Z1,Z5` runs a few, `--seed` makes the same inputs again.
`--n 100000` says 100,000 lines, sends 200,000 messages and 10,000 connections, 50 MB and 500 walks of 30 steps.
Exit code 1 if anything fell over, was wrongly accepted, or moved.
"""

import argparse
import random
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path

from tests.fuzzing import bus, console, serial, walk
from tests.fuzzing.promises import PROMISES
from tests.support.figures import Report, Result, Results, machine, table

KEPT = 1000

Scenario = Callable[[Results, int, random.Random], None]
SCENARIOS: dict[str, tuple[Scenario, float]] = {
    "Z1": (console.consoles, 1.0),
    "Z4": (bus.messages, 2.0),
    "Z5": (serial.lines, 0.0005),
    "Z7": (walk.walks, 0.005),
}
"""Each with its share of `--n`: lines, messages, MB, walks."""


def main() -> int:
    """Throw, print, and say whether anything fell over."""
    arguments = _arguments()
    report = measure(arguments.only or list(SCENARIOS), arguments.n, arguments.seed)
    if arguments.json:
        report.write(arguments.json)
    print(table(report.results))
    return report.tell_broken()


def measure(names: list[str], n: int, seed: int) -> Report:
    """Run one after the other; one that cannot go on counts as a violation."""
    results = Results(PROMISES)
    began, started = time.monotonic(), time.strftime("%Y-%m-%d %H:%M:%S %Z")
    for name in names:
        scenario, share = SCENARIOS[name]
        since = time.monotonic()
        try:
            scenario(results, max(1, round(n * share)), random.Random(f"{name} {seed}"))
        except Exception as err:  # noqa: BLE001 - what went wrong is a finding, and the others are still wanted
            traceback.print_exc()
            results.check(name, [f"could not go on: {err}"])
        took_s = time.monotonic() - since
        print(f"{name}: {results.of(name).n} in {took_s:.0f} s, {results.of(name).n / took_s:.0f}/s", file=sys.stderr)
    ordered = [thinned(results.by_figure[figure]) for figure in PROMISES if figure in results.by_figure]
    return Report(
        machine=machine(),
        load=f"seed {seed}",
        started=started,
        took_s=round(time.monotonic() - began, 1),
        results=ordered,
    )


def thinned(result: Result) -> Result:
    """Return a result that says the same with at most a thousand samples; it still counts them all."""
    result.checks = result.n
    samples = sorted(result.samples)
    step = max(1, len(samples) // KEPT)
    result.samples = samples[::-1][::step]
    result.violations = result.violations[:50]
    return result


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=1000, help="how much, more or less (default %(default)s)")
    parser.add_argument("--only", type=lambda text: text.split(","), default=[], metavar="Z1,Z5")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
