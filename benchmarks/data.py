"""Measures that rows, audit trail and the emergency stop's latch survive kills, damage, bad edits and a full disk.

`python -m benchmarks.data --n 30 --json FILE`; `--only D1,D4` runs a few scenarios, `--seed` makes the same damage again.
`--n 100` is the full amount: 1,000 kills, 5,000 mutated databases, every 512 bytes and 2,000 flipped bits. Exit code 1
if anything was lost or wrong was accepted.
"""

import argparse
import random
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path

from tests.scenarios import data_audit, data_damage, data_disk, data_kills, data_life, data_mutations
from tests.scenarios.data_promises import PROMISES
from tests.support.figures import Report, Results, machine, table

Scenario = Callable[[Results, int], None]


def scenarios(seed: int) -> dict[str, tuple[Scenario, float]]:
    """Return every scenario with its share of `--n`; chance is the seed's."""
    return {
        "D1": (lambda results, n: data_kills.kills(results, n, random.Random(seed)), 10.0),
        "D2": (lambda results, n: data_mutations.mutations(results, n, random.Random(seed)), 50.0),
        "D4": (lambda results, n: data_damage.damages(results, n, random.Random(seed)), 20.0),
        "D6": (lambda results, n: data_audit.audits(results, n, random.Random(seed)), 0.1),
        "E2": (data_life.lives, 0.1),
        "E6": (data_disk.disks, 0.1),
    }


def main() -> int:
    """Measure, print, and say whether anything was lost."""
    arguments = _arguments()
    report = measure(arguments.only, arguments.n, arguments.seed)
    if arguments.json:
        report.write(arguments.json)
    print(table(report.results))
    return report.tell_broken()


def measure(names: list[str], n: int, seed: int) -> Report:
    """Run scenarios one after the other; one that cannot go on counts as a violation."""
    results = Results(PROMISES)
    began, started = time.monotonic(), time.strftime("%Y-%m-%d %H:%M:%S %Z")
    for name, (scenario, share) in scenarios(seed).items():
        if names and name not in names:
            continue
        since = time.monotonic()
        try:
            scenario(results, max(1, round(n * share)))
        except Exception as err:  # noqa: BLE001 - what went wrong is a finding, and the others are still wanted
            traceback.print_exc()
            results.check(next(f for f in PROMISES if f.startswith(name)), [f"the scenario could not go on: {err}"])
        print(f"{name}: {time.monotonic() - since:.0f} s", file=sys.stderr, flush=True)
    ordered = [results.by_figure[figure] for figure in PROMISES if figure in results.by_figure]
    took_s = round(time.monotonic() - began, 1)
    return Report(machine=machine(), load=f"seed {seed}", started=started, took_s=took_s, results=ordered)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=5, help="how much, more or less (default %(default)s)")
    parser.add_argument("--only", type=lambda text: text.split(","), default=[], metavar="D1,D4")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
