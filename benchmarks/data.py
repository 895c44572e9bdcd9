"""Measures that rows, audit trail and the emergency stop's latch survive kills, damage, bad edits and a full disk.

`python -m benchmarks data --n 30 --json FILE`; `--only D1,D4` runs a few scenarios, `--seed` makes the same damage
again. `--n 100` is the full amount: 1,000 kills, 5,000 mutated databases, every 512 bytes and 2,000 flipped bits. Exit
code 1 if anything was lost, or anything wrong was accepted.
"""

import argparse
import random
from collections.abc import Callable
from functools import partial

from benchmarks import Measured, listed, one_by_one
from tests.scenarios import data_audit, data_damage, data_disk, data_kills, data_life, data_mutations
from tests.scenarios.data_promises import PROMISES
from tests.support.figures import Results

SMOKE = "--n 1 --only D4"

Scenario = Callable[[Results, int], None]


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount, and the scenarios."""
    parser.add_argument("--n", type=int, default=5, help="how much, more or less (default %(default)s)")
    parser.add_argument("--only", type=listed, default=[], metavar="D1,D4")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Run scenarios one after the other."""
    results = Results(PROMISES)
    chosen = {name: what for name, what in scenarios(given.seed).items() if not given.only or name in given.only}
    one_by_one(
        results,
        (
            (
                name,
                next(f for f in PROMISES if f.startswith(name)),
                partial(scenario, results, max(1, round(given.n * share))),
            )
            for name, (scenario, share) in chosen.items()
        ),
    )
    return Measured(results=results.ordered(), load=f"seed {given.seed}")


def scenarios(seed: int) -> dict[str, tuple[Scenario, float]]:
    """Return every scenario with its share of `--n`; the seed determines the random numbers."""
    return {
        "D1": (lambda results, n: data_kills.kills(results, n, random.Random(seed)), 10.0),
        "D2": (lambda results, n: data_mutations.mutations(results, n, random.Random(seed)), 50.0),
        "D4": (lambda results, n: data_damage.damages(results, n, random.Random(seed)), 20.0),
        "D6": (lambda results, n: data_audit.audits(results, n, random.Random(seed)), 0.1),
        "E2": (data_life.lives, 0.1),
        "E6": (data_disk.disks, 0.1),
    }
